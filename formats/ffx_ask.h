/* The forward coder's questions about a corner of a face, and the facts that make them cheap. Private to formats/ffx*. */
#ifndef CAGEWRIGHT_FFX_ASK_H
#define CAGEWRIGHT_FFX_ASK_H

#include "formats/ffx_forward.h"

/* Does the chain go on along the boundary, behind e or else behind c? closes: that would end the face. */
unsigned ask_along(struct forward *forward, const struct step *step, bool is_behind, bool closes, unsigned truth);
/* Does a new edge lead to e and end the face? */
unsigned ask_close(struct forward *forward, const struct step *step, unsigned truth);
/* Is the next vertex new? */
unsigned ask_new(struct forward *forward, const struct step *step, unsigned truth);

#endif

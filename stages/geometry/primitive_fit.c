/* Fitting analytic surfaces: closed first guesses, then Gauss-Newton on the distance with Levenberg's damping. */
#include <math.h>
#include <string.h>

#include "stages/geometry/eigen3.h"
#include "stages/geometry/primitive.h"
#include "stages/geometry/vector.h"

#define PARAMETER_MOST 7
#define STEP_DEFAULT 30

static double weight_of(const double *weight, size_t i)
{
	return weight ? weight[i] : 1;
}

/* Solve the symmetric positive definite n x n system (n <= 7) by Cholesky; false when it is not definite. */
static bool solve_spd(double *x, const double *a, const double *b, int n)
{
	double l[PARAMETER_MOST * PARAMETER_MOST];
	for (int i = 0; i < n; i++)
		for (int j = 0; j <= i; j++) {
			double sum = a[i * n + j];
			for (int k = 0; k < j; k++)
				sum -= l[i * n + k] * l[j * n + k];
			if (i == j) {
				if (!(sum > 0))
					return false;
				l[i * n + i] = sqrt(sum);
			} else {
				l[i * n + j] = sum / l[j * n + j];
			}
		}
	for (int i = 0; i < n; i++) {
		x[i] = b[i];
		for (int k = 0; k < i; k++)
			x[i] -= l[i * n + k] * x[k];
		x[i] /= l[i * n + i];
	}
	for (int i = n - 1; i >= 0; i--) {
		for (int k = i + 1; k < n; k++)
			x[i] -= l[k * n + i] * x[k];
		x[i] /= l[i * n + i];
	}
	return true;
}

static void weighted_mean(double mean[3], const double *v, const double *weight, size_t count)
{
	double total = 0;
	mean[0] = mean[1] = mean[2] = 0;
	for (size_t i = 0; i < count; i++) {
		add_scaled3(mean, weight_of(weight, i), v + 3 * i);
		total += weight_of(weight, i);
	}
	scale3(mean, 1 / total);
}

/* Eigenvectors of sum w (v - about)(v - about)^T / sum w, ascending. */
static void principal_axes(double value[3], double vector[3][3], const double *v, const double about[3], const double *weight, size_t count)
{
	double m[6] = {0}, total = 0;
	for (size_t i = 0; i < count; i++) {
		const double w = weight_of(weight, i);
		double d[3];
		sub3(d, v + 3 * i, about);
		m[0] += w * d[0] * d[0], m[1] += w * d[0] * d[1], m[2] += w * d[0] * d[2];
		m[3] += w * d[1] * d[1], m[4] += w * d[1] * d[2], m[5] += w * d[2] * d[2];
		total += w;
	}
	for (int i = 0; i < 6; i++)
		m[i] /= total;
	eigen3_symmetric(value, vector, m);
}

static const double origin[3] = {0, 0, 0};

static void guess_plane(struct dense_patch *patch, const double *xyz, const double *normal, const double *weight, size_t count)
{
	double mean_normal[3];
	weighted_mean(patch->point, xyz, weight, count);
	weighted_mean(mean_normal, normal, weight, count);
	normalise3(mean_normal);
	copy3(patch->axis, mean_normal);
}

/* x = centre + radius * n in the plane perpendicular to axis (axis NULL: in space), by linear regression of x on n.
 * radius comes out signed: negative where the normals point inward. */
static bool regress_centre(double centre[3], double *radius, const double *axis, const double *xyz, const double *normal, const double *weight, size_t count)
{
	double mx[3], mn[3], xn = 0, nn = 0;
	weighted_mean(mx, xyz, weight, count);
	weighted_mean(mn, normal, weight, count);
	if (axis)
		add_scaled3(mn, -dot3(mn, axis), axis);
	for (size_t i = 0; i < count; i++) {
		double dx[3], dn[3];
		sub3(dx, xyz + 3 * i, mx);
		copy3(dn, normal + 3 * i);
		if (axis)
			add_scaled3(dn, -dot3(dn, axis), axis);
		sub3(dn, dn, mn);
		xn += weight_of(weight, i) * dot3(dx, dn);
		nn += weight_of(weight, i) * dot3(dn, dn);
	}
	if (!(nn > 0) || xn == 0)
		return false;
	*radius = xn / nn;
	copy3(centre, mx);
	add_scaled3(centre, -*radius, mn);
	return isfinite(*radius);
}

static bool guess_round(struct dense_patch *patch, const double *axis, const double *xyz, const double *normal, const double *weight, size_t count)
{
	double radius;
	if (!regress_centre(patch->point, &radius, axis, xyz, normal, weight, count))
		return false;
	patch->radius = fabs(radius);
	patch->sign = radius < 0 ? -1 : 1;
	return true;
}

static bool guess_cone(struct dense_patch *patch, const double *xyz, const double *normal, const double *weight, size_t count)
{
	double mean[3], value[3], vector[3][3], a[9] = {0}, b[3] = {0}, centre[3], apex[3], to[3], away = 0, along = 0;
	weighted_mean(mean, normal, weight, count);
	principal_axes(value, vector, normal, mean, weight, count);
	copy3(patch->axis, vector[0]);
	/* the apex lies on all tangent planes */
	weighted_mean(centre, xyz, weight, count);
	for (size_t i = 0; i < count; i++) {
		const double *n = normal + 3 * i;
		double d[3];
		sub3(d, xyz + 3 * i, centre);
		const double h = dot3(n, d), w = weight_of(weight, i);
		for (int r = 0; r < 3; r++) {
			for (int c = 0; c < 3; c++)
				a[3 * r + c] += w * n[r] * n[c];
			b[r] += w * n[r] * h;
		}
	}
	if (!solve_spd(apex, a, b, 3))
		return false;
	for (int i = 0; i < 3; i++)
		patch->point[i] = centre[i] + apex[i];
	sub3(to, centre, patch->point);
	if (dot3(to, patch->axis) < 0)
		scale3(patch->axis, -1);
	along = dot3(to, patch->axis);
	for (size_t i = 0; i < count; i++) {
		double d[3];
		sub3(d, xyz + 3 * i, patch->point);
		const double h = dot3(d, patch->axis);
		add_scaled3(d, -h, patch->axis);
		away += weight_of(weight, i) * dot3(d, normal + 3 * i);
	}
	patch->sign = away < 0 ? -1 : 1;
	const double tilt = -patch->sign * dot3(mean, patch->axis); /* n = sign (cos away - sin axis) */
	patch->radius = 0;
	patch->radius2 = asin(fmin(1, fmax(-1, tilt))) * DEGREES;
	return along > 0 && patch->radius2 > 0.02 && patch->radius2 < 89.98;
}

/* Axis of revolution from the normal lines: minimise sum (a . (x cross n) + b . n)^2 with |a| = 1. */
static bool guess_torus(struct dense_patch *patch, const double *xyz, const double *normal, const double *weight, size_t count)
{
	double centre[3], mm[9] = {0}, mn[9] = {0}, nn[9] = {0}, extent = 0, total = 0;
	weighted_mean(centre, xyz, weight, count);
	for (size_t i = 0; i < count; i++) {
		extent += weight_of(weight, i) * distance3(xyz + 3 * i, centre);
		total += weight_of(weight, i);
	}
	extent /= total;
	if (!(extent > 0))
		return false;
	for (size_t i = 0; i < count; i++) {
		const double *n = normal + 3 * i, w = weight_of(weight, i);
		double d[3], m[3];
		sub3(d, xyz + 3 * i, centre);
		scale3(d, 1 / extent);
		cross3(m, d, n);
		for (int r = 0; r < 3; r++)
			for (int c = 0; c < 3; c++) {
				mm[3 * r + c] += w * m[r] * m[c];
				mn[3 * r + c] += w * m[r] * n[c];
				nn[3 * r + c] += w * n[r] * n[c];
			}
	}
	/* b = -nn^-1 mn^T a; Schur complement mm - mn nn^-1 mn^T */
	double inverse[9], value[3], vector[3][3];
	for (int i = 0; i < 3; i++)
		nn[4 * i] += 1e-9 * total;
	for (int c = 0; c < 3; c++) {
		double e[3] = {0, 0, 0}, column[3];
		e[c] = 1;
		if (!solve_spd(column, nn, e, 3))
			return false;
		for (int r = 0; r < 3; r++)
			inverse[3 * r + c] = column[r];
	}
	double q[9], schur[9]; /* q = nn^-1 mn^T */
	for (int r = 0; r < 3; r++)
		for (int c = 0; c < 3; c++) {
			q[3 * r + c] = 0;
			for (int k = 0; k < 3; k++)
				q[3 * r + c] += inverse[3 * r + k] * mn[3 * c + k];
		}
	for (int r = 0; r < 3; r++)
		for (int c = 0; c < 3; c++) {
			schur[3 * r + c] = mm[3 * r + c];
			for (int k = 0; k < 3; k++)
				schur[3 * r + c] -= mn[3 * r + k] * q[3 * k + c];
		}
	const double packed[6] = {schur[0], (schur[1] + schur[3]) / 2, (schur[2] + schur[6]) / 2, schur[4], (schur[5] + schur[7]) / 2, schur[8]};
	eigen3_symmetric(value, vector, packed);
	double b[3], foot[3];
	for (int r = 0; r < 3; r++) {
		b[r] = 0;
		for (int k = 0; k < 3; k++)
			b[r] -= q[3 * r + k] * vector[0][k];
	}
	copy3(patch->axis, vector[0]);
	cross3(foot, patch->axis, b); /* b = p cross a for the point p of the axis nearest to the centre */
	for (int i = 0; i < 3; i++)
		foot[i] = centre[i] + extent * foot[i];
	/* profile in the half-plane (rho, height): a circle, by regression of points on normals */
	double sum[4] = {0}, xn = 0, dn = 0;
	for (int pass = 0; pass < 2; pass++)
		for (size_t i = 0; i < count; i++) {
			double d[3], w = weight_of(weight, i);
			sub3(d, xyz + 3 * i, foot);
			const double h = dot3(d, patch->axis), nh = dot3(normal + 3 * i, patch->axis);
			add_scaled3(d, -h, patch->axis);
			const double rho = normalise3(d), nr = dot3(normal + 3 * i, d);
			if (pass == 0) {
				sum[0] += w * rho, sum[1] += w * h, sum[2] += w * nr, sum[3] += w * nh;
			} else {
				xn += w * ((rho - sum[0] / total) * (nr - sum[2] / total) + (h - sum[1] / total) * (nh - sum[3] / total));
				dn += w * ((nr - sum[2] / total) * (nr - sum[2] / total) + (nh - sum[3] / total) * (nh - sum[3] / total));
			}
		}
	if (!(dn > 1e-12 * total) || xn == 0)
		return false;
	const double tube = xn / dn;
	patch->radius = sum[0] / total - tube * sum[2] / total;
	patch->radius2 = fabs(tube);
	patch->sign = tube < 0 ? -1 : 1;
	copy3(patch->point, foot);
	add_scaled3(patch->point, sum[1] / total - tube * sum[3] / total, patch->axis);
	return patch->radius > 0;
}

bool primitive_guess(struct dense_patch *patch, enum patch_kind kind, const double *xyz, const double *normal, const double *weight, size_t count)
{
	double value[3], vector[3][3];
	if (count == 0)
		return false;
	patch->kind = kind;
	patch->radius = patch->radius2 = patch->sign = 0;
	memset(patch->axis, 0, sizeof patch->axis);
	switch (kind) {
	case PATCH_PLANE:
		guess_plane(patch, xyz, normal, weight, count);
		return norm3(patch->axis) > 0;
	case PATCH_SPHERE:
		return guess_round(patch, NULL, xyz, normal, weight, count);
	case PATCH_CYLINDER:
		principal_axes(value, vector, normal, origin, weight, count);
		copy3(patch->axis, vector[0]);
		return guess_round(patch, patch->axis, xyz, normal, weight, count);
	case PATCH_CONE:
		return guess_cone(patch, xyz, normal, weight, count);
	case PATCH_TORUS:
		return guess_torus(patch, xyz, normal, weight, count);
	case PATCH_FREE:
		break;
	}
	return false;
}

/* The parameters while fitting: point p, unit axis a with u, v perpendicular to it, and up to two more numbers.
 * A cone is held by the radius at p instead of its apex, which may be far away. */
struct model {
	enum patch_kind kind;
	double p[3], a[3], u[3], v[3], r1, r2;
	double c, s; /* cosine and sine of a cone's half angle r2 */
};

static void set_frame(struct model *m)
{
	m->c = cos(m->r2);
	m->s = sin(m->r2);
	const int k = fabs(m->a[0]) <= fabs(m->a[1]) ? (fabs(m->a[0]) <= fabs(m->a[2]) ? 0 : 2) : (fabs(m->a[1]) <= fabs(m->a[2]) ? 1 : 2);
	double e[3] = {0, 0, 0};
	e[k] = 1;
	cross3(m->u, m->a, e);
	normalise3(m->u);
	cross3(m->v, m->a, m->u);
}

/* Distance away from axis or centre > 0, and its derivatives by the parameters. */
static double residual_row(double row[PARAMETER_MOST], const struct model *m, const double x[3])
{
	double d[3], away[3];
	sub3(d, x, m->p);
	if (m->kind == PATCH_SPHERE) {
		const double length = normalise3(d);
		for (int i = 0; i < 3; i++)
			row[i] = -d[i];
		row[3] = -1;
		return length - m->r1;
	}
	const double h = dot3(d, m->a);
	copy3(away, d);
	add_scaled3(away, -h, m->a);
	const double rho = normalise3(away), cu = dot3(away, m->u), cv = dot3(away, m->v);
	if (m->kind == PATCH_CYLINDER) {
		row[0] = -cu, row[1] = -cv, row[2] = -h * cu, row[3] = -h * cv, row[4] = -1;
		return rho - m->r1;
	}
	if (m->kind == PATCH_CONE) {
		const double c = m->c, s = m->s;
		row[0] = -c * cu, row[1] = -c * cv;
		row[2] = (-h * c - rho * s) * cu, row[3] = (-h * c - rho * s) * cv;
		row[4] = -c, row[5] = -(rho - m->r1) * s - h * c;
		return (rho - m->r1) * c - h * s;
	}
	const double q = rho - m->r1, s = sqrt(q * q + h * h), f = s > 0 ? 1 / s : 0;
	row[0] = -q * f * cu, row[1] = -q * f * cv, row[2] = -h * f;
	row[3] = h * m->r1 * f * cu, row[4] = h * m->r1 * f * cv;
	row[5] = -q * f, row[6] = -1;
	return s - m->r2;
}

static void model_move(struct model *m, const double *step)
{
	int first_axis = 0;
	switch (m->kind) {
	case PATCH_SPHERE:
		for (int i = 0; i < 3; i++)
			m->p[i] += step[i];
		m->r1 += step[3];
		return;
	case PATCH_TORUS:
		add_scaled3(m->p, step[2], m->a);
		first_axis = 3;
		m->r1 += step[5], m->r2 += step[6];
		break;
	case PATCH_CONE:
		m->r2 += step[5];
		m->r1 += step[4];
		first_axis = 2;
		break;
	default:
		m->r1 += step[4];
		first_axis = 2;
	}
	add_scaled3(m->p, step[0], m->u);
	add_scaled3(m->p, step[1], m->v);
	add_scaled3(m->a, step[first_axis], m->u);
	add_scaled3(m->a, step[first_axis + 1], m->v);
	normalise3(m->a);
	set_frame(m);
}

static bool model_sound(const struct model *m)
{
	const double most = 1e4; /* points have unit extent */
	if (!isfinite(m->r1) || !isfinite(m->r2) || !isfinite(m->p[0] + m->p[1] + m->p[2] + m->a[0]))
		return false;
	switch (m->kind) {
	case PATCH_CONE:
		return fabs(m->r1) < most && m->r2 > 0.02 / DEGREES && m->r2 < 89.98 / DEGREES;
	case PATCH_TORUS:
		return m->r1 > 0 && m->r1 < most && m->r2 > 0 && m->r2 < most;
	default:
		return m->r1 > 0 && m->r1 < most;
	}
}

/* Sum of squared residuals with the normal equations of a Gauss-Newton step. */
struct normal_equations {
	double a[PARAMETER_MOST * PARAMETER_MOST], b[PARAMETER_MOST], error;
};

static void linearise(struct normal_equations *e, const struct model *m, int n, const double *xyz, const double *weight, size_t count, const double centre[3], double scale)
{
	*e = (struct normal_equations){0};
	for (size_t i = 0; i < count; i++) {
		double x[3], row[PARAMETER_MOST];
		const double w = weight_of(weight, i);
		for (int k = 0; k < 3; k++)
			x[k] = (xyz[3 * i + k] - centre[k]) * scale;
		const double r = residual_row(row, m, x);
		for (int j = 0; j < n; j++) {
			for (int k = 0; k <= j; k++)
				e->a[j * n + k] += w * row[j] * row[k];
			e->b[j] -= w * row[j] * r;
		}
		e->error += w * r * r;
	}
}

static bool fit_plane(struct dense_patch *patch, const double *xyz, const double *weight, size_t count)
{
	double value[3], vector[3][3], mean[3];
	weighted_mean(mean, xyz, weight, count);
	principal_axes(value, vector, xyz, mean, weight, count);
	if (!(value[1] > 1e-20 * value[2])) /* points on a line determine no plane */
		return false;
	if (dot3(vector[0], patch->axis) < 0)
		scale3(vector[0], -1);
	copy3(patch->axis, vector[0]);
	copy3(patch->point, mean);
	return true;
}

bool primitive_fit(struct dense_patch *patch, const double *xyz, const double *weight, size_t count, int step_limit)
{
	const int n = primitive_parameter_count(patch->kind);
	double centre[3], extent = 0;
	if (n == 0 || count < (size_t)n)
		return false;
	if (patch->kind == PATCH_PLANE)
		return fit_plane(patch, xyz, weight, count);
	weighted_mean(centre, xyz, weight, count);
	for (size_t i = 0; i < count; i++)
		extent = fmax(extent, distance3(xyz + 3 * i, centre));
	if (!(extent > 0))
		return false;
	const double scale = 1 / extent;
	struct model m = {.kind = patch->kind, .r1 = patch->radius * scale, .r2 = patch->radius2 * scale};
	for (int k = 0; k < 3; k++)
		m.p[k] = (patch->point[k] - centre[k]) * scale;
	copy3(m.a, patch->axis);
	if (patch->kind != PATCH_SPHERE) {
		normalise3(m.a);
		set_frame(&m);
	}
	if (patch->kind == PATCH_CONE || patch->kind == PATCH_CYLINDER) {
		/* hold the point of the axis that is nearest to the centre of the points */
		const double h = dot3(m.p, m.a);
		add_scaled3(m.p, -h, m.a);
		if (patch->kind == PATCH_CONE)
			m.r2 = patch->radius2 / DEGREES, m.r1 = -h * tan(m.r2), set_frame(&m);
	}
	if (!model_sound(&m))
		return false;
	double damping = 1e-6;
	struct normal_equations now, then;
	linearise(&now, &m, n, xyz, weight, count, centre, scale);
	const int steps = step_limit ? step_limit : STEP_DEFAULT;
	bool is_settled = false;
	for (int step = 0; step < steps && !is_settled; step++) {
		double trace = 0;
		for (int j = 0; j < n; j++)
			trace += now.a[j * n + j];
		bool better = false;
		for (int tries = 0; tries < 5 && !better; tries++) {
			double damped[PARAMETER_MOST * PARAMETER_MOST], move[PARAMETER_MOST];
			memcpy(damped, now.a, sizeof damped);
			for (int j = 0; j < n; j++)
				damped[j * n + j] += damping * now.a[j * n + j] + 1e-14 * trace;
			struct model next = m;
			then.error = INFINITY;
			if (solve_spd(move, damped, now.b, n)) {
				model_move(&next, move);
				if (model_sound(&next))
					linearise(&then, &next, n, xyz, weight, count, centre, scale);
			}
			if (then.error <= now.error) {
				is_settled = now.error - then.error <= 1e-8 * now.error || then.error <= 1e-28 * (double)count;
				better = true;
				m = next;
				now = then;
				damping = fmax(1e-12, damping / 10);
			} else {
				damping = fmax(1e-4, damping * 10);
			}
		}
		if (!better)
			break;
	}
	for (int k = 0; k < 3; k++)
		patch->point[k] = centre[k] + m.p[k] * extent;
	copy3(patch->axis, m.a);
	patch->radius = m.r1 * extent;
	patch->radius2 = m.r2 * extent;
	if (patch->kind == PATCH_CONE) {
		/* from the point of the axis back to the apex */
		add_scaled3(patch->point, -m.r1 / tan(m.r2) * extent, m.a);
		patch->radius = 0;
		patch->radius2 = m.r2 * DEGREES;
	} else if (patch->kind != PATCH_TORUS) {
		patch->radius2 = 0;
	}
	if (patch->kind == PATCH_SPHERE)
		memset(patch->axis, 0, sizeof patch->axis);
	return true;
}

#!/bin/sh
# What programs say, word for word.
exec sh "${ROOT:-.}/tests/tools/golden"

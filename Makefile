# The two commands of a fresh checkout; everything else is meson (see README.md).
# `make demo` shows a picture, `make test` runs every test, `make test-VARIANT` one variant of them
# (release, asan, tsan, arm64). Both install what is missing where they may.

demo:
	@sh scripts/setup.sh build
	@sh scripts/demo.sh

test:
	@sh scripts/test.sh release asan tsan arm64

test-%:
	@sh scripts/test.sh $*

.PHONY: demo test

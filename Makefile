# The commands of a fresh checkout; everything else is meson (see README.md).
# `make demo` shows a picture, `make test` runs the tests, `make test-VARIANT` one variant of them
# (release, long, asan, tsan, fuzz, farm, arm64; `long` and `fuzz` only so). Both install what is missing where they may. `make quality` measures methods against
# pictures of a real lens, where such scenes are at hand, and writes docs/quality. `make fuzz-TARGET` is in CONTRIBUTING.md.

demo:
	@sh scripts/setup.sh build
	@sh scripts/demo.sh

test:
	@sh scripts/test.sh release asan tsan farm arm64

fuzz-%:
	@sh scripts/fuzz.sh $*

test-%:
	@sh scripts/test.sh $*

quality:
	@sh scripts/setup.sh build
	@sh scripts/quality.sh

.PHONY: demo test quality

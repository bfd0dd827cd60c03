# SPDX-FileCopyrightText: 2026 The ddof authors
# SPDX-License-Identifier: MIT
#
# Damaged and unusual files through info, render and compare: they succeed or fail with one line, and never crash.
# Meant for a build with sanitizers; worth running in any.
# shellcheck shell=sh disable=SC2154,SC2086
. "${SOURCE:?}/tests/tools/tap.sh"
images=$DATA/openexr-images
if [ ! -d "$images" ]; then
    skip "damaged files" "no DDOF_DATA"
    done_testing
    exit
fi
"$FIXTURE" make "$work/good.exr" 64 48 float 32 R=0.5 G=0.5 B=0.5 Z=3

# survives DESCRIPTION COMMAND...: exit code 0, or 1 or 2 with one last line "ddof: ..." that is an error
survives() {
    about=$1
    shift
    run "$@"
    if grep -Eq 'Sanitizer|runtime error' "$work/err"; then
        not_ok "$about" "a sanitizer reports"
    elif [ $status -eq 0 ]; then
        ok "$about"
    elif [ $status -gt 2 ]; then
        not_ok "$about" "exit code $status"
    elif [ "$(grep -vc '^ddof: note: ' "$work/err")" -ne 1 ] || ! tail -1 "$work/err" | grep -q '^ddof: '; then
        not_ok "$about" "not one line on standard error"
    elif [ -n "$(ls -A "$work/o")" ]; then
        not_ok "$about" "left behind: $(ls "$work/o")"
    else
        ok "$about"
    fi
    rm -f "$work/o/"*
}

blur="--focus 3 --max-coc 5"
for file in "$images"/Damaged/* "$images"/*/*.exr "$images"/v2/*/*.exr; do
    case $file in *README*) continue ;; esac
    name=${file#"$images/"}
    survives "info $name" "$DDOF" info "$file"
    survives "render $name" "$DDOF" render "$file" -o "$work/o/out.exr" $blur
    survives "render $name to PNG" "$DDOF" render "$file" -o "$work/o/out.png" $blur --preview "$work/o/p.png"
    survives "coc $name" "$DDOF" coc "$file" -o "$work/o/out.exr" --coc "$file"
    survives "depth from $name" "$DDOF" render "$work/good.exr" -o "$work/o/out.exr" $blur --depth "$file"
    survives "compare $name" "$DDOF" compare "$file" "$file"
done
done_testing

# SPDX-FileCopyrightText: 2026 The ddof authors
# SPDX-License-Identifier: MIT
#
# Reading the command line: help, suggestions, every option's value and range, and that the documents know every option.
# shellcheck shell=sh disable=SC2154
. "${SOURCE:?}/tests/tools/tap.sh"
o=$work/o/out.exr
in=$work/in.exr
"$FIXTURE" make "$in" 16 8 float 32 R=0.5 G=0.5 B=0.5 Z=ramp:1:20
lens="--fstop 2 --focus 4 --focal-length 50"

# --- help and version
passes "version" "$DDOF" --version
check "version is a number" grep -Eq '^ddof [0-9]+\.[0-9]+\.[0-9]+$' "$work/out"
passes "help" "$DDOF" --help
check "help names the commands" grep -q 'ddof compare' "$work/out"
run "$DDOF"
if [ $status -eq 2 ] && grep -q usage "$work/err" && [ ! -s "$work/out" ]; then ok "no arguments"; else not_ok "no arguments"; fi
for command in render coc info compare bench solvers devices; do
    passes "$command --help" "$DDOF" $command --help
    check "$command --help has examples" grep -q "^  ddof $command" "$work/out"
    check "$command --help has exit codes" grep -q 'exit codes' "$work/out"
    cp "$work/out" "$work/help.$command"
    passes "help $command" "$DDOF" help $command
    check "help $command is $command --help" cmp "$work/out" "$work/help.$command"
    check "$command --help fits in 100 columns" awk 'length($0) > 100 && !/^(usage|  ddof|ddof)/ { exit 1 }' "$work/out"
done
passes "-h wins over what is missing" "$DDOF" render -h
refuses "help of an unknown command" 2 'blur: no such command' "$DDOF" help blur

# --- commands and options that do not exist
refuses "unknown command" 2 "rendr: no such command; did you mean 'ddof render'" "$DDOF" rendr
refuses "unknown command, nothing near" 2 'xyzzy: no such command; there are' "$DDOF" xyzzy
refuses "unknown option" 2 '--focs: unknown option; did you mean --focus\?' "$DDOF" render "$in" -o "$o" --focs 3
refuses "unknown option with value" 2 '--fstp: unknown option; did you mean --fstop\?' "$DDOF" render "$in" -o "$o" --fstp=3
refuses "start of an option" 2 '--conduct: unknown option; did you mean --conductance\?' "$DDOF" render "$in" -o "$o" --conduct classic
refuses "unknown option, nothing near" 2 "--zzzzzzzz: unknown option; see 'ddof info --help'" "$DDOF" info "$in" --zzzzzzzz
refuses "option of another command" 2 "--size: not an option of 'ddof render' but of 'ddof bench'" "$DDOF" render "$in" -o "$o" --size 3x3
refuses "unknown letter" 2 '-x: unknown option' "$DDOF" info -x "$in"

# --- how options are written
# shellcheck disable=SC2086
{
    passes "--option=value" "$DDOF" render "$in" "--output=$o" --fstop=2 --focus=4 --focal-length=50 -q
    passes "-oFILE" "$DDOF" render "$in" "-o$o" $lens -q
    passes "options before the file" "$DDOF" render $lens -q -o "$o" "$in"
    passes "the last one counts" "$DDOF" render "$in" -o "$work/nowhere/x.exr" $lens --fstop 3 --fstop=4 -o "$o" -q
    (cd "$work" && cp in.exr ./--quiet)
    passes "-- ends the options" sh -c "cd '$work' && '$DDOF' render -o o/out.exr $lens -- --quiet"
    rm -f "$work/o/out.exr" "$work/--quiet"
    refuses "value forgotten" 2 '--focus: needs a value, like --focus 3.2' "$DDOF" render "$in" -o "$o" --focus --quiet
    refuses "value forgotten at the end" 2 '--fstop: needs a value' "$DDOF" render "$in" -o "$o" --fstop
    refuses "value too many" 2 '--quiet: takes no value' "$DDOF" render "$in" -o "$o" --quiet=yes
    refuses "file too many" 2 'extra.exr: one argument too many' "$DDOF" render "$in" extra.exr -o "$o"
    refuses "file missing" 2 "IN: the picture's file name is missing; usage: ddof render IN -o OUT" "$DDOF" render -o "$o"
    refuses "second file missing" 2 "B: the picture's file name is missing" "$DDOF" compare "$in"
    refuses "file for bench" 2 'one argument too many' "$DDOF" bench "$in"
    refuses "empty file name" 2 'an empty file name' "$DDOF" info ''
    refuses "output missing" 2 '--output: missing' "$DDOF" render "$in" $lens
    refuses "output empty" 2 '--output: empty' "$DDOF" render "$in" -o '' $lens
    refuses "output ending" 2 '--output: .*out.jpg: unknown ending; use .exr' "$DDOF" render "$in" -o "$work/o/out.jpg" $lens
}

# --- numbers
bad() { # OPTION VALUE PATTERN
    refuses "--$1 $2" 2 "--$1: .*$3" "$DDOF" render "$in" -o "$o" "--$1=$2"
}
for value in abc '' ' 3' 3x 0x10 nan NaN inf 1e999 2,8 --3 '3 '; do bad fstop "$value" 'not a number'; done
for value in 0 -1 -0.0 1e7; do
    for option in fstop focal-length sensor-width; do bad $option $value 'out of range'; done
done
bad unit 0 'out of range'
bad unit nan 'not a number'
for option in focus near far; do
    for value in 0 -1 -inf; do bad $option $value '(out of range|not a number)'; done
    bad $option nan 'not a number'
done
bad focus-range -1 'out of range; it must be at least 0'
bad focus-range inf 'not a number'
for option in max-coc max-coc-near max-coc-far; do
    bad $option -1 'out of range'
    bad $option 1e6 'out of range'
    bad $option 'x%' 'not a number of pixels or percent'
    bad $option % 'not a number of pixels or percent'
    bad $option nan 'not a number'
done
for value in 3 '3,' ',3' 3,4,5 a,b 3x4 nan,3; do bad focus-at "$value" 'not X,Y'; done
bad focus-at -1,3 'out of range'
bad focus-at 50%,101% 'out of range; the picture ends at 100%'
bad depth-kind plane 'none of planar\|ray'
bad conductance new 'none of matched\|classic'
bad kernel box 'none of heat\|disc'
bad quality high 'none of draft\|good\|best'
bad layers 3 'none of off\|auto'
for option in "--substeps 2" "--conductance matched"; do
    # shellcheck disable=SC2086
    refuses "disc kernel with $option" 2 "${option%% *}: cannot be used together with --kernel disc; --quality" "$DDOF" render "$in" -o "$o" $lens --kernel disc $option
done
# shellcheck disable=SC2086
for kernel in "" "--kernel heat"; do
    refuses "quality without the disc kernel ${kernel}" 2 '--quality: needs --kernel disc too' "$DDOF" render "$in" -o "$o" $lens $kernel --quality good
done
bad backend gpu 'none of auto\|cpu\|gl\|vulkan\|reference'
for value in -1 1.5 1024 x; do bad device $value '(out of range|whole number|not a)'; done
bad solver cr5 'none of cr-vanilla\|cr\|cr\+pack'
bad surface rgba8 'none of rgba16f\|rgba32f'
for value in 0 -1 1e7 nan x; do
    refuses "compare --amplify $value" 2 '--amplify: .*(out of range|not a number)' "$DDOF" compare "$in" "$in" -o "$work/o/d.png" --amplify=$value
done
bad cpu sse 'none of baseline'
bad cpu avx2,,neon 'none of baseline'
for value in 0 65 1.5 x; do bad substeps $value '(out of range|whole number)'; done
for value in -1 257 1.5; do bad threads $value '(out of range|whole number)'; done
bad exposure 31 'out of range'
bad coc-scale 1e7 'out of range'
bad coc-scale nan 'not a number'
for value in 3 3x x3 0x3 3x0 1.5x3 -3x3 3x2000000 5%x5; do
    refuses "bench --size $value" 2 '--size: .*(not WIDTHxHEIGHT|out of range)' "$DDOF" bench --size $value
done
refuses "bench --channels 5" 2 '--channels: 5 is out of range' "$DDOF" bench --channels 5
refuses "bench --runs 0" 2 '--runs: 0 is out of range' "$DDOF" bench --runs 0
refuses "bench --type double" 2 "--type: 'double' is none of float\|half" "$DDOF" bench --type double
refuses "bench --layout tiled" 2 "--layout: 'tiled' is none of" "$DDOF" bench --layout tiled
refuses "bench --format text" 2 "--format: 'text' is none of markdown\|csv\|json" "$DDOF" bench --table --format text
refuses "bench --coc -1" 2 '--coc: -1 is out of range' "$DDOF" bench --coc -1
refuses "bench too large for this machine" 2 '--size: .*make it smaller' "$DDOF" bench --size 1048576x1048576

# --- every option is documented, and completed
for command in render coc info compare bench solvers devices; do
    for option in $(grep -Eo '^  (-[a-z], )?--[a-z-]+' "$work/help.$command" | grep -Eo -e '--[a-z-]+'); do
        escaped=$(echo "$option" | sed 's/-/\\\\-/g')
        check "$command $option is in docs/cli.md" grep -q -e "$option" "$SOURCE/docs/cli.md"
        check "$command $option is in the man page" grep -q -e "$escaped" "$SOURCE/docs/man/ddof.1"
    done
done
if command -v bash >/dev/null 2>&1; then
    completions() { # WORD...: what bash offers for the last one
        bash -c 'source "$1"; shift; COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); _ddof; printf "%s\n" "${COMPREPLY[@]}"' \
            bash "$SOURCE/completions/ddof.bash" "$@" 2>/dev/null
    }
    for command in render coc info compare bench solvers devices; do
        completions ddof $command -- | sort >"$work/completed"
        grep -Eo '^  (-[a-z], )?--[a-z-]+' "$work/help.$command" | grep -Eo -e '--[a-z-]+' | sort >"$work/listed"
        check "completion of $command offers exactly its options" cmp "$work/completed" "$work/listed"
    done
    check "completion of commands" sh -c "[ \"$(completions ddof ren)\" = render ]"
    check "completion of values" sh -c "[ \"$(completions ddof render --depth-kind in)\" = inverse ]"
    check "completion of files" sh -c "[ \"$(completions ddof info "$work/in.e")\" = '$work/in.exr' ]"
else
    skip "completion" "no bash"
fi
if command -v man >/dev/null 2>&1; then
    check "man page has no warnings" sh -c "! LC_ALL=C.UTF-8 MANROFFSEQ='' MANWIDTH=80 man --warnings -E UTF-8 -l -Tutf8 -Z '$SOURCE/docs/man/ddof.1' 2>&1 >/dev/null | grep ."
else
    skip "man page has no warnings" "no man"
fi
refuses "standard output that cannot be written" 1 'standard output: .*could not be printed' sh -c "'$DDOF' --version >/dev/full"
done_testing

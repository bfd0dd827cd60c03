#!/bin/sh
# SPDX-FileCopyrightText: 2026 The ddof authors
# SPDX-License-Identifier: MIT

# scale.sh [SCENES]: what a frame of a shot costs here; the figures of docs/scale.md. SCENES (../shared/data/scenes/seq) holds
# pinhole.0001.exr to pinhole.0012.exr, 480x270, which are measured as they are and tiled to 1920x1080 and 3840x2160. Wants a quiet
# machine. DDOF and FIXTURE name the programs (build/tools/ddof, build/tests/tools/fixture), TMPDIR where the frames are written.
set -eu
cd "$(dirname "$0")/.."
scenes=${1:-../shared/data/scenes/seq}
ddof=${DDOF:-$PWD/build/tools/ddof} fixture=${FIXTURE:-$PWD/build/tests/tools/fixture}
[ -f "$scenes/pinhole.0012.exr" ] || { echo "scale.sh: $scenes: no pinhole.0001.exr to pinhole.0012.exr there" >&2; exit 1; }
work=$(mktemp -d "${TMPDIR:-/tmp}/ddof-scale.XXXXXX")
trap 'rm -rf "$work"' EXIT
trap 'exit 1' HUP INT PIPE TERM
mkdir "$work/270p" "$work/1080p" "$work/4K" "$work/o"
lens="--fstop 1.4 --focal-length 50 --focus 3.5"

for n in $(seq 24); do
    from=$(printf '%s/pinhole.%04d.exr' "$scenes" $(((n - 1) % 12 + 1)))
    [ "$n" -gt 9 ] || cp "$from" "$(printf '%s/270p/a.%04d.exr' "$work" "$n")"
    "$fixture" tile "$from" "$(printf '%s/1080p/a.%04d.exr' "$work" "$n")" 4 4
    [ "$n" -gt 4 ] || "$fixture" tile "$from" "$(printf '%s/4K/a.%04d.exr' "$work" "$n")" 8 8
done

# shot SIZE FRAMES OPTION...: JSON lines into $work/log
shot() {
    folder=$work/$1 list=$2
    shift 2
    # shellcheck disable=SC2086
    "$ddof" render "$folder/a.####.exr" -o "$work/o/a.####.exr" --frames "$list" $lens --json "$@" >"$work/log" 2>/dev/null
}

# sum KEY: of the last line
sum() { tail -n 1 "$work/log" | "$fixture" json "$1"; }
median() { sort -n | awk '{ v[NR] = $1 } END { print NR % 2 ? v[(NR + 1) / 2] : (v[NR / 2] + v[NR / 2 + 1]) / 2 }'; }
part() { sed -n "s/.*\"$1\":\([0-9.e+-]*\).*/\1/p" "$work/log" | median; }
megabytes() { stat -c %s "$@" | awk '{ s += $1 } END { printf "%.2f", s / NR / 1e6 }'; }

echo "$(sed -n 's/^model name[^:]*: //p' /proc/cpuinfo | sort -u | head -n 1), $(nproc) processors; $(stat -f -c %T "$work"); $("$ddof" --version | head -n 1); load $(cut -d' ' -f1 /proc/loadavg) before"
echo
echo "One frame, RGBA half and Z float, ZIP, one thread, one in flight. cpu_s: user and system; the parts are medians of wall time."
printf '%-6s %-12s %6s %9s %9s %9s %8s %8s %7s\n' size method cpu_s decode_ms solve_ms encode_ms read_MB write_MB rss_MB
row() { # SIZE FRAMES COUNT NAME OPTION...
    size=$1 list=$2 number=$3 name=$4
    shift 4
    shot "$size" "$list" --threads 1 --in-flight 1 "$@"
    printf '%-6s %-12s %6.3f %9.0f %9.0f %9.0f %8s %8s %7.0f\n' "$size" "$name" \
        "$(awk "BEGIN { print $(sum cores_busy) * $(sum total_ms) / 1e3 / $number }")" "$(part decode_ms)" "$(part solve_ms)" \
        "$(part encode_ms)" "$(megabytes "$work/$size"/a.000[1-"$number"].exr)" "$(megabytes "$work"/o/a.000[1-"$number"].exr)" \
        "$(awk "BEGIN { print $(sum peak_rss_bytes) / 1e6 }")"
}
for size in 270p 1080p 4K; do
    number=4
    [ $size != 270p ] || number=9 # as rendered, not tiled: what ZIP makes of a picture that repeats is smaller
    row $size 1-$number $number none --method none
    row $size 1-$number $number default
    row $size 1-$number $number disc --kernel disc
    row $size 1-$number $number disc+layers --kernel disc --layers auto
done

echo
echo "Memory of a process with more frames in flight, 1080p, default: "
for n in 1 2 3 6; do
    shot 1080p 1-12 --in-flight $n
    echo "in flight $n: $(awk "BEGIN { printf \"%.0f MB, %.2f s a frame, %.2f cores busy\", $(sum peak_rss_bytes) / 1e6, $(sum total_ms) / 12e3, $(sum cores_busy) }")"
done

echo
echo "24 frames of 1080p, all processors, default against --method none, in turn:"
: >"$work/none"
: >"$work/default"
for _ in 1 2 3; do
    shot 1080p 1-24 --method none
    echo "$(sum total_ms) $(sum cores_busy)" >>"$work/none"
    shot 1080p 1-24
    echo "$(sum total_ms) $(sum cores_busy)" >>"$work/default"
done
none=$(cut -d' ' -f1 "$work/none" | median) default=$(cut -d' ' -f1 "$work/default" | median)
awk "BEGIN { printf \"none %.2f s, default %.2f s: ratio %.3f\n\", $none / 1e3, $default / 1e3, $default / $none }"
awk "BEGIN { printf \"cores busy: none %.2f, default %.2f, of $(nproc): %.0f %%\n\", $(cut -d' ' -f2 "$work/none" | median), \
    $(cut -d' ' -f2 "$work/default" | median), 100 * $(cut -d' ' -f2 "$work/default" | median) / $(nproc) }"

if command -v strace >/dev/null; then
    echo
    echo "System calls on files of one frame more (13 frames less 1, by 12), 1080p, --resume:"
    calls() { # FRAMES FILE
        rm -rf "$work/o"
        mkdir "$work/o"
        # shellcheck disable=SC2086
        strace -f -qq -c -o "$2" "$ddof" render "$work/1080p/a.####.exr" -o "$work/o/a.####.exr" --frames "$1" $lens --resume --quiet
    }
    calls 1 "$work/one"
    calls 1-13 "$work/many"
    for name in openat stat newfstatat fstat access readlink linkat rename renameat mkdir unlink pread64 read write pwrite64 fsync fdatasync; do
        awk -v name=$name '$NF == name { n[FILENAME == ARGV[1]] = $4 }
            END { d = (n[0] - n[1]) / 12; if (d > 0) printf "%s %.1f  ", name, d }' "$work/one" "$work/many"
    done
    echo
    # shellcheck disable=SC2086
    strace -f -T -e trace=fsync,fdatasync -o "$work/sync" "$ddof" render "$work/1080p/a.####.exr" -o "$work/o/a.####.exr" \
        --frames 14-24 $lens --quiet
    echo "fsync of one frame, ms, median: $(sed -n 's/.*<\([0-9.]*\)>$/\1/p' "$work/sync" | awk '{ print $1 * 1e3 }' | median)"
fi
echo
echo "load $(cut -d' ' -f1 /proc/loadavg) after"

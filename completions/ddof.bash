# SPDX-FileCopyrightText: 2026 The ddof authors
# SPDX-License-Identifier: MIT
#
# bash completion for ddof; installed as bash-completion/completions/ddof. Every option of --help is here (a test checks).

_ddof_options() {
    local blur="--layer --depth --depth-kind --near --far --coc --coc-scale --camera --render --focal-length
        --sensor-width --fstop --unit --focus --focus-at --focus-range --autofocus --focus-smooth --animate --metadata --max-coc --max-coc-near --max-coc-far"
    local engine="--threads --backend --device --cpu" memory="--max-memory --scratch" gpu="--solver --surface --shared-chain"
    local bokeh="--bokeh --iris --bokeh-threshold --bokeh-limit --max-sprites --max-sprite-area --bokeh-resolution"
    local shot="--frames --resume --keep-going --in-flight" report="--quiet --json --help"
    case $1 in
        render) echo "--output $shot $blur --channels --views --method --kernel --quality --conductance --substeps --layers $bokeh --holdout --preview --exposure $memory $engine $gpu $report" ;;
        coc) echo "--output $shot $blur --exposure $memory $engine $report" ;;
        info) echo "--layer --depth --metadata --threads $report" ;;
        compare) echo "--output --layer --mask --coc --ppd --amplify --invert --threads $report" ;;
        bench) echo "--size --runs --type --layout --channels --in-place --coc --depth --table --format --reference
            --method --conductance --substeps --kernel --quality $bokeh --append --quads $engine $gpu $report" ;;
        solvers) echo "--size $report" ;;
        devices) echo "$report" ;;
    esac
}

_ddof_files() {
    local IFS=$'\n'
    compopt -o filenames 2>/dev/null
    # shellcheck disable=SC2207 # one name a line
    COMPREPLY=($(compgen -f -X "!*.@($1)" -- "$2") $(compgen -d -- "$2"))
}

_ddof() {
    local word=${COMP_WORDS[COMP_CWORD]} previous=${COMP_WORDS[COMP_CWORD - 1]} command=${COMP_WORDS[1]} extglob
    local pictures='exr|EXR|png|PNG|tif|tiff|TIF|TIFF|pfm|PFM|heic|HEIC|heif|hif|HIF|avif|jxl'
    COMPREPLY=()
    extglob=$(shopt -p extglob)
    shopt -s extglob
    if ((COMP_CWORD == 1)); then
        mapfile -t COMPREPLY < <(compgen -W "render coc info compare bench solvers devices help --help --version" -- "$word")
    elif [[ $command == help ]]; then
        mapfile -t COMPREPLY < <(compgen -W "render coc info compare bench solvers devices" -- "$word")
    else
        _ddof_value "$command" "$previous" "$word" || {
            if [[ $word == -* ]]; then
                mapfile -t COMPREPLY < <(compgen -W "$(_ddof_options "$command")" -- "$word")
            elif [[ $command != bench && $command != solvers && $command != devices ]]; then
                _ddof_files "$pictures" "$word"
            fi
        }
    fi
    $extglob
}

# The value of the option before the cursor; fails when that option has none.
_ddof_value() {
    local choices=
    case $2 in
        --depth-kind) choices="planar ray inverse normalized device" ;;
        --method) choices="diffusion gaussian hexagon scatter none" ;;
        --bokeh) choices="off highlights full" ;;
        --metadata) choices="auto focus= fstop= focal-length= sensor-width=" ;;
        --iris) choices="disc blades= image=" ;;
        --bokeh-resolution) choices="full half" ;;
        --append) choices="counter arguments" ;;
        --quads) choices="instanced geometry" ;;
        --kernel) choices="heat disc" ;;
        --quality) choices="draft good best" ;;
        --layers) choices="auto off" ;;
        --views) choices="all left right left,right" ;;
        --conductance) choices="matched classic" ;;
        --backend) choices="auto cpu gl vulkan reference" ;;
        --solver) choices="cr-vanilla cr cr+pack cr4 cr4+pack cr+pcr line pcr pcr3+sweep" ;;
        --surface) choices="rgba16f rgba32f" ;;
        --format) choices="markdown csv json" ;;
        --cpu) choices="all baseline avx2 avx512 neon" ;;
        --type) choices="float half" ;;
        --layout) choices="interleaved planar" ;;
        --size) choices="1280x720 1600x1200 1920x1080 3840x2160" ;;
        --max-memory) choices="512M 2G 8G" ;;
        --scratch) compopt -o filenames 2>/dev/null; mapfile -t COMPREPLY < <(compgen -d -- "$3"); return 0 ;;
        --camera | --animate) _ddof_files 'json' "$3"; return 0 ;;
        --preview) _ddof_files 'png' "$3"; return 0 ;;
        -o | --output | --mask | --holdout) _ddof_files "$pictures" "$3"; return 0 ;;
        --depth | --coc)
            [[ $1 == bench && $2 == --depth ]] && return 1
            [[ $1 == bench ]] && return 0
            _ddof_files "$pictures" "$3"
            return 0
            ;;
        --frames | --in-flight | --layer | --near | --far | --coc-scale | --render | --focal-length | --sensor-width | --fstop | --unit | --focus | \
            --focus-at | --focus-range | --autofocus | --focus-smooth | --max-coc | --max-coc-near | --max-coc-far | --runs | --channels | --substeps | \
            --bokeh-threshold | --bokeh-limit | --max-sprites | --max-sprite-area | --amplify | --exposure | --threads | --device) return 0 ;;
        *) return 1 ;;
    esac
    mapfile -t COMPREPLY < <(compgen -W "$choices" -- "$3")
}

complete -F _ddof ddof

#!/bin/sh
# SPDX-FileCopyrightText: 2026 The ddof authors
# SPDX-License-Identifier: MIT
#
# contrib/slurm/shot.sbatch on a Slurm of one node that lives in a temporary folder, with ports and keys of its own: eight tasks
# render a shot, one is killed in the middle and requeued, one is told that its time is over and requeues itself; every frame
# is that of a local run, and what was complete before is not rendered again. Run by `make test-farm`. Environment as tap.sh.
# shellcheck source=tests/tools/tap.sh
. "${SOURCE:?}/tests/tools/tap.sh"
for program in munged slurmctld slurmd sbatch scontrol squeue; do
    command -v $program >/dev/null || PATH=$PATH:/usr/sbin:/sbin
    command -v $program >/dev/null && continue
    skip "a farm" "$program is not there; install slurmctld slurmd slurm-client munge"
    done_testing
    exit
done
cd "$work" || exit 1

# ------------------------------------------------------------------------- helpers

# within SECONDS COMMAND...: waits until it succeeds.
within() {
    end=$(($(date +%s) + $1))
    shift
    until "$@" >/dev/null 2>&1; do
        [ "$(date +%s)" -lt $end ] || return 1
        sleep 0.05
    done
}

gone() { ! kill -0 "$1" 2>/dev/null; }

is() { if [ "$2" = "$3" ]; then ok "$1"; else not_ok "$1" "got '$2' instead of '$3'"; fi; }

daemons='' controller=''
# Jobs first, since their processes belong to no daemon; then the daemons, the last one first.
stop_farm() {
    if [ -n "$controller" ]; then
        scancel -u "$(id -un)" 2>/dev/null
        within 20 no_job
        for pid in $(scontrol listpids "" farm 2>/dev/null | awk '$1 + 0 > 0 { print $1 }'); do kill -KILL "$pid" 2>/dev/null; done
    fi
    for pid in $daemons; do
        kill "$pid" 2>/dev/null
        within 10 gone "$pid" || kill -KILL "$pid"
    done
    daemons='' controller=''
}
trap 'stop_farm; rm -rf "$work"' EXIT

give_up() {
    not_ok "$1" "$(tail -n 5 ctld.log slurmd.log munge.log 2>/dev/null)"
    done_testing
    exit 1
}

# ------------------------------------------------------------------------- a cluster

# A port that nobody has now; a real cluster's are 6817 and 6818.
free_port() {
    port=$(($(od -An -N2 -tu2 /dev/urandom) % 20000 + 20000))
    while grep -qi ":$(printf %04x "$port") " /proc/net/tcp /proc/net/tcp6 2>/dev/null; do port=$((port + 1)); done
    echo "$port"
}

configure() {
    chmod 711 "$work" # munge wants its socket to be within everyone's reach
    mkdir -m 711 munge
    mkdir -m 700 state spool
    head -c 128 /dev/urandom >munge/key
    chmod 600 munge/key
    cat >slurm.conf <<EOF
ClusterName=ddof-test
SlurmctldHost=$(hostname)(127.0.0.1)
SlurmctldPort=$1
SlurmdPort=$2
SlurmUser=$(id -un)
SlurmdUser=$(id -un)
AuthType=auth/munge
AuthInfo=socket=$work/munge/socket,cred_expire=5
StateSaveLocation=$work/state
SlurmdSpoolDir=$work/spool
SlurmctldPidFile=$work/ctld.pid
SlurmdPidFile=$work/slurmd.pid
SlurmctldLogFile=$work/ctld.log
SlurmdLogFile=$work/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SchedulerParameters=sched_interval=1,bf_interval=1
SlurmdParameters=config_overrides
ReturnToService=2
KillWait=2
MessageTimeout=60
NodeName=farm NodeHostname=$(hostname) NodeAddr=127.0.0.1 CPUs=2 RealMemory=16000 State=UNKNOWN
PartitionName=all Nodes=farm Default=YES MaxTime=INFINITE State=UP
EOF
}

# Daemons in the foreground of a background process: their ids are known, and none asks for an init system.
start_farm() {
    munged -F --socket="$work/munge/socket" --key-file="$work/munge/key" --log-file="$work/munge.log" \
        --pid-file="$work/munge/pid" --seed-file="$work/munge/seed" >munge.out 2>&1 &
    daemons=$!
    within 30 test -S munge/socket || give_up "munge starts"
    slurmctld -D >ctld.out 2>&1 &
    daemons="$! $daemons"
    within 30 ctld_answers || give_up "slurmctld starts"
    controller=yes
    slurmd -D -N farm >slurmd.out 2>&1 &
    daemons="$! $daemons"
    within 60 node_is_up || give_up "Slurm starts"
    ok "munge, slurmctld and slurmd run on $(hostname)"
}

ctld_answers() { timeout 10 scontrol ping | grep -q UP; }
node_is_up() { sinfo -h -n farm -o %t | grep -q '^idle'; }
no_job() { [ -z "$(squeue -h -o %A)" ]; }

# ------------------------------------------------------------------------- a shot

lens="--fstop 1.4 --focus 4 --kernel disc --in-flight 1"
tasks=8 frames=24
input='plates/sh 010.####.exr' output='dof/sh 010.####.exr'

frame() { printf '%s/sh 010.%04d.exr' "$1" "$2"; }
record() { printf 'dof/.ddof/sh 010.%04d.exr.json' "$1"; }

# The second frames of tasks 2 and 4 are large, so that there is time to meet them in the middle.
make_shot() {
    mkdir plates dof local
    for n in $(seq $frames); do
        "$FIXTURE" make "$(frame plates "$n")" 160 90 half 16 "R=noise@$n,3=9" G=ramp:0:1 B=down:0:2 A=1 Z=ramp:2:20
    done
    for n in 11 13; do
        mv "$(frame plates $n)" small.exr
        "$FIXTURE" tile small.exr "$(frame plates $n)" 20 20
    done
    rm small.exr
    "$DDOF" render "$input" -o 'local/sh 010.####.exr' --frames 1-$frames $lens --quiet || not_ok "a local run"
}

submit() { # NAME ARRAY FRAMES [OPTION]...: the number of the job
    name=$1 array=$2 list=$3
    shift 3
    DDOF=$DDOF sbatch --parsable --array="$array" --cpus-per-task=1 --mem=100M --job-name="$name" --output="$name-%a.jsonl" \
        --error="$name-%a.err" "$SOURCE/contrib/slurm/shot.sbatch" "$input" "$output" "$list" $lens "$@"
}

state() { scontrol -o show job "$1" | sed -n 's/.* JobState=\([A-Z_]*\) .*/\1/p'; }
states() { scontrol -o show job "$1" | sed -n 's/.* JobState=\([A-Z_]*\) .*/\1/p' | sort | uniq -c | sed 's/^ *//'; }
has_ended() { case $(state "$1") in PENDING | RUNNING | COMPLETING | '') return 1 ;; esac; }
begun() { [ -s "$(record "$1")" ] || has_ended "$2"; }

# Each task is a job, too; its own number means no other task of the array.
job_number() { scontrol -o show job "$1" | sed -n 's/^JobId=\([0-9]*\) .*/\1/p'; }

# The processes of a task: the shell, ddof, and the step's keeper before them.
kill_all() {
    pids=$(scontrol listpids "$(job_number "$1")" farm | awk '$1 + 0 > 0 { print $1 }')
    shell=$(echo "$pids" | head -n 1)
    keeper=$(awk '{ sub(/.*\) /, ""); print $2 }' "/proc/$shell/stat")
    kill -KILL $keeper $pids
}

time_is_up() { scancel --batch --signal=USR1 "$(job_number "$1")"; }

# in_the_middle ACTION TASK: does it when the task's first frame is complete. Where it came too late the task begins anew.
in_the_middle() {
    first=$(($2 + 1)) last=$(($2 + 17)) tries=0
    while [ $tries -lt 5 ]; do
        tries=$((tries + 1))
        within 120 begun $first "${job}_$2"
        stat -c %y "$(frame dof $first)" "$(record $first)" >"before.$2"
        $1 "${job}_$2" 2>action.err && ! [ -e "$(frame dof $last)" ] && ok "task $2 in the middle: $1" && return
        within 60 has_ended "${job}_$2"
        rm -f "$(frame dof $first)" "$(frame dof $((first + tasks)))" "$(frame dof $last)" "$(record $first)"
        scontrol requeue "${job}_$2"
    done
    not_ok "task $2 in the middle: $1" "it had ended $tries times before that"
}

# of TASK KEY: what its log says of each frame, in order.
of() { sed -n "s/.*\"frame\":\([0-9]*\),\"status\":\"\([a-z]*\)\".*/\1 \2/p" "shot-$1.jsonl" | tr '\n' ' '; }

same_as_local() { # DESCRIPTION
    differ=
    for n in $(seq $frames); do
        cmp -s "$(frame local "$n")" "$(frame dof "$n")" || differ="$differ $n"
    done
    is "$1" "$differ" ""
}

configure "$(free_port)" "$(free_port)"
export SLURM_CONF="$work/slurm.conf"
unset SLURM_JOB_ID SLURM_ARRAY_JOB_ID SLURM_ARRAY_TASK_ID SLURM_CLUSTERS
start_farm
make_shot

job=$(submit shot 0-$((tasks - 1)) 1-$frames)
is "submitted" "${job:+yes}" yes
in_the_middle kill_all 2
scontrol requeue "${job}_2"
in_the_middle time_is_up 4
within 240 no_job || not_ok "the array ends" "$(squeue)"
is "every task ends well" "$(states "$job")" "$tasks COMPLETED"
same_as_local "$frames frames are those of a local run, byte by byte"
for task in 2 4; do
    first=$((task + 1))
    stat -c %y "$(frame dof $first)" "$(record $first)" >after
    check "task $task: what was complete was not written again" cmp "before.$task" after
done
is "killed: begun, then the others" "$(of 2)" "3 rendered 3 skipped 11 rendered 19 rendered "
is "nothing is left but frames and records" "$(find dof -type f ! -name 'sh 010.*' | grep -v '^dof/.ddof-.*tmp$')" ""

# ------------------------------------------------------------------------- other splits

job=$(DDOF_SPLIT=blocks submit blocks 0-6 1-3,4-10x2,11-$frames)
within 120 no_job
is "blocks, of ranges that no number of tasks divides: nothing to do twice" \
    "$(states "$job")|$(grep -h -c '"status":"rendered"' blocks-*.jsonl | sort -u)" "7 COMPLETED|0"
is "each frame once" "$(sed -n 's/.*"frame":\([0-9]*\),"status":"skipped".*/\1/p' blocks-*.jsonl | sort -n | tr '\n' ' ')" \
    "$(for n in 1 2 3 4 6 8 10 $(seq 11 $frames); do printf '%s ' "$n"; done)"
job=$(submit many 0-3 1-2)
within 120 no_job
is "more tasks than frames" "$(states "$job")|$(cat many-*.err | grep -c 'nothing to do')" "4 COMPLETED|2"
job=$(submit parts 1,3 1-$frames)
within 120 no_job
is "part of an array is refused" "$(states "$job")|$(cat parts-*.err | grep -c 'has to be 0-N')" "2 FAILED|2"
job=$(submit missing 0-1 23-26)
within 120 no_job
failed=$(sed -n 's/.*"frame":\([0-9]*\),"status":"failed".*/\1/p' missing-*.jsonl | sort -n | paste -sd,)
is "frames that fail are named" "$(states "$job")|$failed" "2 FAILED|25,26"
done_testing

#!/usr/bin/env bash
# `evograsp bench dispatch` measures a real dispatcher: nobody is lost, work is done, what is known is sent once.
source "$(dirname "$0")/lib.sh"

# run ARGUMENTS...: a short measurement into $figures
run() { expect 0 "$evograsp" bench dispatch --seconds 1 --json "$@"; cp out figures; }
# holds FILTER TEXT
holds() { [ "$(jq "$1" figures)" = true ] || fail "$2: $(tr -d '\n' <figures)"; }

run --workers 20 --task-ms 20
holds '.workers_at_the_end == 20 and .workers_lost == 0 and .refused == 0' "workers were lost"
holds '.busy_share > 0.3 and .busy_share <= 1' "the slots are not busy"
holds '.genome_bytes > 19000 and .genome_bytes < 21000' "the genome has not the size asked for"
holds '.packed_bytes * 2.8 < .genome_bytes' "a genome is hardly packed"
# Beside the packed network: what a task says, and what is under way at the ends of the measurement.
holds '.bytes_sent < .packed_bytes * 1.2' "a genome travels unpacked"

run --workers 20 --task-ms 20 --trials 10 --curve
holds '.workers_at_the_end == 20 and .workers_lost == 0' "encrypted workers were lost"
holds '.bytes_sent_a_task * 10 < .genome_bytes' "a network is sent anew for each of its tasks"

expect 2 "$evograsp" bench dispatch --workers 0
finish

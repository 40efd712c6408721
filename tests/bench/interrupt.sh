#!/bin/sh
# How long Ctrl-C takes in every stage of a large run. Runs CONFIG on SCAN once, then every stage alone (its inputs from
# the cache) and interrupts it at shares of the time that it took, and tells the seconds until the program has ended.
#
#   tests/bench/interrupt.sh PROGRAM CONFIG SCAN FOLDER [STAGE ...]
#
# FOLDER takes cache and results. Ends with 1 where the program took more than a second, or did not end with 130.
set -eu
program=$1 config=$2 scan=$3 folder=$4
shift 4
mkdir -p "$folder"
run() { (start "$@"); }
# In place of the shell that calls it, so that a signal to it reaches the program.
start() { exec "$program" run "$config" --set "load.path=$scan" --out "$folder/out" --cache "$folder/cache" "$@"; }
now() { date +%s.%N; }
minus() { awk "BEGIN { printf \"%.3f\", $1 - $2 }"; }
run --quiet > /dev/null
stages=${*:-load orient curvature mesh tree mser borders export report}
failed=0
for stage in $stages; do
  begin=$(now)
  run --quiet --only "$stage" > /dev/null
  whole=$(minus "$(now)" "$begin")
  for share in .15 .3 .45 .6 .75 .9; do
    start --quiet --only "$stage" > /dev/null 2> "$folder/err" &
    process=$!
    sleep "$(awk "BEGIN { print $whole * $share }")"
    if ! kill -INT "$process" 2> /dev/null; then
      wait "$process" || true
      echo "$stage at $share of ${whole}: ended before"
      continue
    fi
    begin=$(now)
    code=0
    wait "$process" || code=$?
    took=$(minus "$(now)" "$begin")
    printf '%s at %s of %.2f s: ended with %d after %.3f s\n' "$stage" "$share" "$whole" "$code" "$took"
    if [ "$code" != 130 ] && [ "$code" != 0 ] || awk "BEGIN { exit !($took > 1) }"; then failed=1; fi
  done
done
exit $failed

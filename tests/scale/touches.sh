#!/usr/bin/env bash
# Ten thousand small touches in one process, against a process for each touch (100 of them, extrapolated); memory over time.
#   tests/scale/touches.sh [PROGRAM]
set -euo pipefail
cd "$(dirname "$0")/../.."
program=$(realpath "${1:-target/release/pliant}")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
jobs=$(nproc)

echo "== one process, $jobs edits at a time"
"$program" batch tests/scale/touches.toml --out "$work/out" --json > "$work/end.json" &
batch=$!
while kill -0 $batch 2>/dev/null; do
  awk '/VmRSS/ {print $2}' "/proc/$batch/status" 2>/dev/null >> "$work/memory" || true
  sleep 1
done
wait $batch
python3 - "$work" <<'PY'
import json, sys
end = json.load(open(sys.argv[1] + "/end.json"))
memory = [int(line) / 1024 for line in open(sys.argv[1] + "/memory")]
tenth = max(1, len(memory) // 10)
mean = lambda values: sum(values) / len(values)
outside = 1 - end["step_seconds"] / end["edit_seconds"]
print(f"{end['done']} edits in {end['elapsed']:.1f} s: {end['done'] / end['elapsed']:.1f} a second, {end['failed']} failed")
print(f"{1e3 * end['edit_seconds'] / end['done']:.2f} ms an edit, {1e3 * end['step_seconds'] / end['done']:.2f} ms of them in steps:"
      f" {100 * outside:.1f} % outside of steps")
print(f"memory: {mean(memory[1:1 + tenth]):.1f} MB in the first tenth, {mean(memory[-tenth:]):.1f} MB in the last")
PY

echo "== a process for each edit, $jobs at a time"
edit() {
  "$program" run scenes/touch.toml --quiet --threads 1 --out "$work/one/$1" --set time.duration="20 ms" \
    --set device.0.params.path="[[0.0, 0.0, 0.0, 0.0005], [0.02, 0.0, 0.0, -0.001]]" --set output.trace=false
}
export -f edit
export program work
began=$(date +%s.%N)
seq 100 | xargs -P "$jobs" -I{} bash -c 'edit {}'
python3 -c "
seconds = $(date +%s.%N) - $began
print(f'100 processes in {seconds:.1f} s: {100 / seconds:.1f} a second; 10,000 would take {10000 / 100 * seconds:.0f} s (extrapolated)')"

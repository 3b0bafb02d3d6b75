# `tools/dev bench`: every figure of the README in one go. Sourced by tools/dev, which has say(), die(), deps() and build().

bench_all_parts=(build dem channels scoreboard sources sizes mosaic accuracy lookup frame)

bench_help() {
  cat <<'TEXT'
tools/dev bench [FOLDER] [options]   measure everything, beside other tools; results go into FOLDER (default: bench)

Builds the release preset, installs the other tools (group bench of tools/packages.txt; goes on without them when that fails), makes a
sample scene in FOLDER/scene when FOLDER has neither that nor an imagery.tif and elevation.tif of its own, and runs the parts one after
the other. Each leaves FOLDER/PART.csv, .svg (where there is a chart) and .md; FOLDER/SUMMARY.md has all tables. A part that fails does not
stop the others; the exit code is 1 then.

Parts:
  build      a 16384 x 16384 image as four jobs, beside libvips, GDAL and maketx, and the parts no builder can avoid     4 min
  dem        heights, beside GDAL                                                                                       10 s
  channels   every channel type in every format, beside gdaladdo                                                         2 min
  scoreboard the cases that pyramid builders get wrong, beside GDAL, libvips and maketx                                 10 s
  sources    the same samples in tiled, striped and compressed TIFFs and in a PNG, beside decoding alone                 1 min
  sizes      0.25, 1 and 4 gigapixels: memory and rate                                                                   1 min
  mosaic     10,000 files beside one                                                                                     2 min
  accuracy   speed against error, every kernel, format and compression, beside GDAL and libvips                          1 min
  lookup     finding and reading tiles in an index of a million tiles                                                   20 s
  frame      a flight over the scene by both OpenGL paths                                                               30 s

Options:
  --part LIST     only these parts, with commas
  --full          also 16 gigapixels, an index of 10^9 tiles and zstd level 19: some 15 minutes and 30 GB of disk more
  --quick         small inputs, one run: shows in a minute or two that everything works; its figures mean nothing
  --runs N        runs of build, dem, channels, sources and accuracy, the median counts (default: 3)
  --threads N     of every program (default: one per core)
  --no-install    use what is installed
  --dry-run       print the commands, run nothing
  --help          this text

All parts: about a quarter of an hour on two idle cores with a disk of 500 MB/s, and 20 GB of disk; a slow disk adds some minutes, making the
scene and compiling some more the first time. Times above are estimates. Nothing else should run meanwhile: other load makes
figures too low, and vtbench says when it sees some.

Examples:
  tools/dev bench results
  tools/dev bench results --part build,dem --runs 5
  tools/dev bench /fast/disk/results --full
TEXT
}

# Prints a command, and runs it unless this is a dry run.
bench_run() {
  if [[ $bench_dry == 1 ]]; then
    printf '%q ' "$@"
    printf '\n'
  else
    "$@"
  fi
}

bench_make_scene() {
  bench_scene="$bench_folder/scene"
  if [[ -f "$bench_folder/imagery.tif" && -f "$bench_folder/elevation.tif" ]]; then
    bench_scene="$bench_folder"
  elif [[ ! -f "$bench_scene/SCENE.json" ]]; then  # is written last
    say "making a scene of $bench_size x $bench_size in $bench_scene"
    bench_run "$bench_bin/vtbuild" sample -o "$bench_scene" --size "$bench_size" --progress plain
  fi
}

# bench_measure PART SUBCOMMAND [arguments]: one vtbench command with its result files.
bench_measure() {
  local part="$1"
  shift
  local results=(--csv "$bench_folder/$part.csv" --markdown "$bench_folder/$part.md")
  [[ " channels scoreboard lookup frame " == *" $part "* ]] || results+=(--svg "$bench_folder/$part.svg")
  bench_run "$bench_bin/vtbench" "$@" --scratch "$bench_folder/scratch" "${results[@]}"
}

bench_part() {
  local imagery="$bench_scene/imagery.tif" threads=(--threads "$bench_threads") runs=(--runs "$bench_runs")
  local channels_size=4096 sources_size=8192 sizes=0.25,1,4 files=10000 accuracy_size=4096 compressions=none,zstd:1,zstd:3,zstd:9 tiles=1000000 frames=300
  if [[ $bench_full == 1 ]]; then
    sizes+=,16
    compressions+=,zstd:19
    tiles+=,1000000000
  fi
  if [[ $bench_quick == 1 ]]; then
    channels_size=256 sources_size=1024 sizes=0.002,0.01 files=100 accuracy_size=512 compressions=none,zstd:1 tiles=10000 frames=10
  fi
  case "$1" in
    build) bench_measure build build "$imagery" "${threads[@]}" "${runs[@]}" ;;
    dem) bench_measure dem build "$bench_scene/elevation.tif" "${threads[@]}" "${runs[@]}" ;;
    channels) bench_measure channels channels --size "$channels_size" "${threads[@]}" "${runs[@]}" ;;
    scoreboard) bench_measure scoreboard scoreboard ;;
    sources) bench_measure sources sources "$imagery" --size "$sources_size" "${threads[@]}" "${runs[@]}" ;;
    sizes) bench_measure sizes sizes "$imagery" --gigapixels "$sizes" "${threads[@]}" ;;
    mosaic) bench_measure mosaic mosaic "$imagery" --files "$files" "${threads[@]}" ;;
    accuracy) bench_measure accuracy accuracy --size "$accuracy_size" --compressions "$compressions" "${threads[@]}" "${runs[@]}" ;;
    lookup) bench_measure lookup lookup --tiles "$tiles" ;;
    frame)
      local store="$bench_folder/scene.vts"
      if [[ ! -f "$store" ]]; then
        local made="$bench_folder/scene.vts.part"
        rm -f "$made"
        bench_run "$bench_bin/vtbuild" layer "$imagery" -o "$made" --channel color --progress plain "${threads[@]}" &&
          bench_run "$bench_bin/vtbuild" layer "$bench_scene/elevation.tif" -o "$made" --channel elevation --progress plain "${threads[@]}" &&
          bench_run mv "$made" "$store" || return
      fi
      bench_measure frame frame "$store" --frames "$frames"
      ;;
  esac
}

bench_title() {
  case "$1" in
    build) echo "Building a pyramid" ;;
    dem) echo "Heights" ;;
    channels) echo "Channel types" ;;
    scoreboard) echo "Hard cases" ;;
    sources) echo "Kinds of files" ;;
    sizes) echo "From small to large" ;;
    mosaic) echo "Many files" ;;
    accuracy) echo "Speed against error" ;;
    lookup) echo "Looking tiles up" ;;
    frame) echo "Frames" ;;
  esac
}

# All parts that have results, those of earlier runs too.
bench_summary() {
  local part
  printf '# Measurements\n\nVersion %s.\n' "$(git describe --always --dirty 2>/dev/null || echo unknown)"
  [[ $bench_quick == 0 ]] || printf '\n**Made with --quick: inputs are so small that these figures mean nothing.**\n'
  for part in "${bench_all_parts[@]}"; do
    [[ -s "$bench_folder/$part.md" ]] || continue
    printf '\n## %s\n\n' "$(bench_title "$part")"
    [[ ! -s "$bench_folder/$part.svg" ]] || printf '![%s](%s.svg)\n\n' "$(bench_title "$part")" "$part"
    cat "$bench_folder/$part.md"
  done
}

bench_options() {
  local part
  while [[ $# -gt 0 ]]; do
    case "$1" in
      --part) IFS=, read -r -a bench_parts <<<"${2:?--part needs names}"; shift ;;
      --runs) bench_runs="${2:?--runs needs a number}"; shift ;;
      --threads) bench_threads="${2:?--threads needs a number}"; shift ;;
      --full) bench_full=1 ;;
      --quick) bench_quick=1 bench_runs=1 bench_size=2048 ;;
      --no-install) bench_install=0 ;;
      --dry-run) bench_dry=1 ;;
      -*) die "bench: unknown option $1; tools/dev bench --help lists them" ;;
      *) bench_folder="$(cd "$here" && realpath -m "$1")" ;;
    esac
    shift
  done
  [[ $bench_full == 0 || $bench_quick == 0 ]] || die "bench: --full and --quick exclude each other"
  for part in "${bench_parts[@]}"; do
    [[ " ${bench_all_parts[*]} " == *" $part "* ]] || die "bench: no part is called '$part'; there are: ${bench_all_parts[*]}"
  done
}

bench() {
  local argument
  for argument in "$@"; do
    [[ $argument != --help && $argument != -h ]] || { bench_help; return; }
  done
  bench_folder=bench bench_parts=("${bench_all_parts[@]}") bench_runs=3 bench_threads="$jobs" bench_size=16384
  bench_full=0 bench_quick=0 bench_install=1 bench_dry=0
  bench_bin=build/release/bin
  bench_options "$@"

  if [[ $bench_dry == 0 ]]; then
    if [[ $bench_install == 1 ]]; then
      deps build
      (deps bench) || say "going on with the other tools that are there"
    fi
    local targets=(vtbench vtbuild)
    [[ " ${bench_parts[*]} " != *" frame "* ]] || targets+=(vtrender)
    build release "${targets[@]}"
    mkdir -p "$bench_folder/scratch"
  fi
  bench_make_scene

  local part status began=$SECONDS part_began failed_parts=()
  for part in "${bench_parts[@]}"; do
    say "$part"
    part_began=$SECONDS
    # Results of an earlier run must not stand for one that fails.
    [[ $bench_dry == 1 ]] || rm -f "$bench_folder/$part".{csv,svg,md}
    status=0
    bench_part "$part" || status=$?
    [[ $status != 130 ]] || die "stopped"
    if [[ $status != 0 ]]; then
      failed_parts+=("$part")
      say "$part failed with exit code $status"
    fi
    say "$part took $((SECONDS - part_began)) s"
  done
  [[ $bench_dry == 0 ]] || return 0
  rmdir "$bench_folder/scratch" 2>/dev/null || say "something is left in $bench_folder/scratch"
  bench_summary >"$bench_folder/SUMMARY.md"
  say "all parts took $((SECONDS - began)) s; the tables are in $bench_folder/SUMMARY.md"
  [[ ${#failed_parts[@]} == 0 ]] || die "these parts failed: ${failed_parts[*]}"
}

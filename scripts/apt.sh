# shellcheck shell=bash
# What setup.sh, mesa22.sh and swiftshader.sh need of apt, as functions: which packages are missing, where newer Mesa drivers come
# from, and a driver unpacked beside the installed one. The backports entry is derived from the system's own sources (same URI, key and options, another suite), so it
# follows whatever mirror the machine uses. Functions that read or write /etc take a root directory, which lets
# tests/setup_test.sh run them on made-up systems. Sourced, never run.

say() { printf '%s: %s\n' "$(basename "$0" .sh)" "$*" >&2; }
die() { say "$@"; exit 1; }

# Runs a command as root; without the means to do that, names the command and fails.
as_root() {
    if [[ $(id -u) -eq 0 ]]; then
        "$@"
    elif command -v sudo >/dev/null; then
        sudo env DEBIAN_FRONTEND=noninteractive "$@"
    else
        say "not root and no sudo, cannot run: $*"
        return 1
    fi
}

can_be_root() {
    [[ $(id -u) -eq 0 ]] && return
    command -v sudo >/dev/null || return
    # Without a terminal sudo could only hang or fail on its password.
    [[ -t 0 ]] || sudo -n true 2>/dev/null
}

apt_get() { as_root apt-get -q -o DPkg::Lock::Timeout=300 "$@"; }

install_packages() { apt_get install -y --no-install-recommends "$@"; }

# Those of the given packages that are not installed, one a line.
missing_packages() {
    local installed package
    installed=$(dpkg-query -W -f '${db:Status-Status} ${Package}\n' "$@" 2>/dev/null | sed -n 's/^installed //p') || true
    for package in "$@"; do
        grep -qxF -- "$package" <<<"$installed" || printf '%s\n' "$package"
    done
}

# The installed version of a package; empty where there is none.
installed_version() {
    dpkg-query -W -f '${db:Status-Status} ${Version}\n' "$1" 2>/dev/null | sed -n 's/^installed //p' || true
}

OWN_ENTRY=penumbra-backports # in /etc/apt/sources.list.d, with the extension of the entry's style
OWN_PIN=penumbra-mesa        # in /etc/apt/preferences.d

# Prints the system's deb822 stanzas that offer `bookworm main`, rewritten to bookworm-backports; stanzas are separated
# by an empty line. With `probe`, prints instead a line for each stanza that offers bookworm-backports main already.
deb822_backports() { # mode, files
    awk -v mode="$1" '
        function words(name) { return " " fields[name] " " }
        function finish(    offers) {
            if (stanza != "" && words("types") ~ / deb / && words("components") ~ / main / && words("enabled") !~ / (no|false|off|0) /) {
                if (mode == "probe") { if (words("suites") ~ / bookworm-backports /) print "found" }
                else if (words("suites") ~ / bookworm /)
                    print stanza "Types: deb\nSuites: bookworm-backports\nComponents: main\n"
            }
            stanza = ""; name = ""; delete fields
        }
        FNR == 1 { finish() }
        /^[ \t]*$/ { finish(); next }
        /^#/ { next }
        {
            if ($0 !~ /^[ \t]/) {
                name = tolower($0); sub(/[ \t]*:.*/, "", name)
                value = $0; sub(/^[^:]*:/, "", value)
            } else value = $0
            gsub(/[ \t]+/, " ", value)
            fields[name] = fields[name] " " (name == "enabled" ? tolower(value) : value)
            if (name != "types" && name != "suites" && name != "components" && name != "enabled") stanza = stanza $0 "\n"
        }
        END { finish() }' "${@:2}"
}

# The same for one-line entries: `deb [options] URI bookworm main ...`, one a line.
oneline_backports() { # mode, files
    awk -v mode="$1" '
        { line = $0; sub(/#.*/, "", line) }
        line !~ /^[ \t]*deb[ \t]/ { next }
        {
            options = ""
            if (match(line, /\[[^]]*\]/)) {
                options = substr(line, RSTART, RLENGTH) " "
                line = substr(line, 1, RSTART - 1) " " substr(line, RSTART + RLENGTH)
            }
            count = split(line, part, /[ \t]+/)
            at = part[1] == "" ? 2 : 1 # part[at] is "deb", then URI, suite, components
            main = 0
            for (i = at + 3; i <= count; i++) if (part[i] == "main") main = 1
            if (!main) next
            if (mode == "probe") { if (part[at + 2] == "bookworm-backports") print "found" }
            else if (part[at + 2] == "bookworm") print "deb " options part[at + 1] " bookworm-backports main"
        }' "${@:2}"
}

# The system's source files of one style, without our own.
source_files() { # root, extension
    local file
    for file in "$1"/etc/apt/sources.list.d/*."$2" ${3:+"$1$3"}; do
        [[ -f $file && $(basename "$file") != "$OWN_ENTRY.$2" ]] && printf '%s\n' "$file"
    done
    return 0
}

has_backports() { # root
    local -a deb822 oneline
    mapfile -t deb822 < <(source_files "$1" sources)
    mapfile -t oneline < <(source_files "$1" list /etc/apt/sources.list)
    [[ ${#deb822[@]} -gt 0 && -n $(deb822_backports probe "${deb822[@]}") ]] ||
        [[ ${#oneline[@]} -gt 0 && -n $(oneline_backports probe "${oneline[@]}") ]]
}

# Writes each entry that might offer backports to a file of its own, 1.sources, 2.list, ..., in the system's order.
# There can be several: a third party's repository may name its suite bookworm too.
write_candidates() { # root, folder
    local -a files
    local count=0 entry line
    mapfile -t files < <(source_files "$1" sources)
    if [[ ${#files[@]} -gt 0 ]]; then
        entry=""
        while IFS= read -r line; do
            if [[ -n $line ]]; then
                entry+="$line"$'\n'
            elif [[ -n $entry ]]; then
                count=$((count + 1))
                printf '%s' "$entry" >"$2/$count.sources"
                entry=""
            fi
        done < <(deb822_backports rewrite "${files[@]}")
    fi
    mapfile -t files < <(source_files "$1" list /etc/apt/sources.list)
    if [[ ${#files[@]} -gt 0 ]]; then
        while IFS= read -r line; do
            count=$((count + 1))
            printf '%s\n' "$line" >"$2/$count.list"
        done < <(oneline_backports rewrite "${files[@]}" | awk '!seen[$0]++')
    fi
}

remove_backports() { # root
    as_root rm -f "$1/etc/apt/sources.list.d/$OWN_ENTRY.sources" "$1/etc/apt/sources.list.d/$OWN_ENTRY.list" \
        "$1/etc/apt/preferences.d/$OWN_PIN"
}

# Pins the Vulkan drivers and libdrm, on which they depend, to backports, and nothing else.
write_pin() { # root
    local pin
    pin=$(mktemp)
    printf '%s\n' 'Package: mesa-vulkan-drivers libdrm*' 'Pin: release n=bookworm-backports' 'Pin-Priority: 600' >"$pin"
    as_root install -D -m 644 "$pin" "$1/etc/apt/preferences.d/$OWN_PIN"
    rm -f "$pin"
}

# Fetches the lists of one source file alone; fails where any of them cannot be had.
update_one() { # file
    apt_get update -o Dir::Etc::sourcelist="$1" -o Dir::Etc::sourceparts=- -o APT::Get::List-Cleanup=0 \
        -o APT::Update::Error-Mode=any
}

# The version of a package that apt would install now.
candidate_version() { LC_ALL=C apt-cache policy "$1" | sed -n 's/^  Candidate: //p'; }

is_new_mesa() { dpkg --compare-versions "${1:-0}" ge 25; }

# Makes backports the source of mesa-vulkan-drivers. Fails, with our files removed again, where that yields no newer
# Mesa: a failing entry would make every later apt-get update fail.
enable_backports() { # root
    local folder entry file
    local -a entries
    remove_backports "$1"
    if has_backports "$1"; then
        write_pin "$1"
        is_new_mesa "$(candidate_version mesa-vulkan-drivers)" && return
        remove_backports "$1"
        return 1
    fi
    folder=$(mktemp -d)
    write_candidates "$1" "$folder"
    mapfile -t entries < <(cd "$folder" && find . -type f -printf '%f\n' | sort -n)
    for entry in "${entries[@]}"; do
        file="$1/etc/apt/sources.list.d/$OWN_ENTRY.${entry##*.}"
        as_root install -D -m 644 "$folder/$entry" "$file"
        if update_one "$file"; then
            write_pin "$1"
            if is_new_mesa "$(candidate_version mesa-vulkan-drivers)"; then
                rm -rf "$folder"
                return 0
            fi
        fi
        remove_backports "$1"
    done
    rm -rf "$folder"
    return 1
}

# Unpacks a package into FOLDER/unpacked without installing it.
unpack_package() { # folder, package=version
    rm -rf "$1"
    mkdir -p "$1"
    say "fetching $2"
    # apt would drop to a user who cannot write here; the package's signature is checked all the same.
    (cd "$1" && apt-get -q -o APT::Sandbox::User="$(id -un)" download "$2" >&2) || die "could not download $2"
    dpkg -x "$1"/*.deb "$1/unpacked"
    rm "$1"/*.deb
}

# Writes a driver's manifest with the absolute path of its library, and prints where. Fails where a library that it needs is
# not installed.
write_manifest() { # library, stock manifest, manifest to write
    local absent
    [[ -n $1 && -n $2 ]] || die "the package holds no such driver"
    absent=$(ldd "$1" | awk '/not found/ { printf " %s", $1 }')
    [[ -z $absent ]] || die "libraries that $(basename "$1") needs are not installed:$absent"
    sed "s|\"library_path\": *\"[^\"]*\"|\"library_path\": \"$1\"|" "$2" >"$3"
    echo "$3"
}

# Whether a manifest is there and so is its library, whose absolute path a moved checkout would break.
manifest_holds() { [[ -f $1 && -f $(sed -n 's/.*"library_path": *"\([^"]*\)".*/\1/p' "$1") ]]; }

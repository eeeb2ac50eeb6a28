// SPDX-License-Identifier: MIT
// How a diagnostic reads, and the suggestion for a misspelt name (edit distance with transpositions: the
// optimal string alignment form of Damerau 1964 / Levenshtein 1966).
#include "penumbra/diagnostic.h"

#include <fmt/format.h>

#include <algorithm>

namespace penumbra {

namespace {

// At most `limit`: what is farther is not told apart.
size_t edit_distance(std::string_view a, std::string_view b, size_t limit) {
    if (std::max(a.size(), b.size()) - std::min(a.size(), b.size()) >= limit) return limit;
    std::vector<size_t> before(b.size() + 1), last(b.size() + 1), row(b.size() + 1);
    for (size_t j = 0; j <= b.size(); ++j) last[j] = j;
    for (size_t i = 1; i <= a.size(); ++i) {
        row[0] = i;
        for (size_t j = 1; j <= b.size(); ++j) {
            row[j] = std::min({last[j] + 1, row[j - 1] + 1, last[j - 1] + (a[i - 1] != b[j - 1])});
            const bool swapped = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
            if (swapped) row[j] = std::min(row[j], before[j - 2] + 1);
        }
        // A swap reaches two rows back, so that two rows in a row have to be too far.
        if (std::min(*std::ranges::min_element(row), *std::ranges::min_element(last)) >= limit) return limit;
        std::swap(before, last);
        std::swap(last, row);
    }
    return std::min(last[b.size()], limit);
}

// Names come from user files and may hold anything; a diagnostic stays one printable line.
std::string one_line(std::string_view text) {
    std::string result;
    for (const char c : text) {
        const auto byte = static_cast<unsigned char>(c);
        if (byte < 0x20 || byte == 0x7f)
            result += fmt::format("\\x{:02x}", byte);
        else
            result += c;
    }
    return result;
}

}  // namespace

std::string to_string(const Place& place) {
    return place.line > 0 ? fmt::format("{}:{}:{}", place.file, place.line, place.column) : place.file;
}

std::string to_string(const Diagnostic& diagnostic) {
    std::string text = to_string(diagnostic.place);
    if (!text.empty()) text += ": ";
    if (!diagnostic.path.empty()) text += diagnostic.path + ": ";
    return one_line(text + diagnostic.message);
}

void Diagnostics::add(Place place, std::string path, std::string message) {
    list_.push_back({std::move(place), std::move(path), std::move(message)});
}

std::string Diagnostics::text() const {
    std::string text;
    for (const Diagnostic& diagnostic : list_) text += to_string(diagnostic) + "\n";
    return text;
}

std::string did_you_mean(std::string_view name, std::span<const std::string> candidates) {
    // A third of the letters may differ: "filterd0" finds "filtered0", "depth" does not find "mask".
    constexpr size_t longest = 64;
    if (name.size() < 2 || name.size() > longest) return "";
    size_t best = std::clamp<size_t>(name.size() / 3, 1, 3) + 1;
    const std::string* nearest = nullptr;
    for (const std::string& candidate : candidates) {
        if (candidate.size() > longest || candidate == name) continue;
        const size_t distance = edit_distance(name, candidate, best);
        if (distance < best) {
            best = distance;
            nearest = &candidate;
        }
    }
    return nearest ? fmt::format("; did you mean \"{}\"?", *nearest) : "";
}

}  // namespace penumbra

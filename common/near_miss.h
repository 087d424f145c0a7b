// "Did you mean ...?": the nearest of a list of known words.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace evograsp {

// Edits (insertions, deletions, substitutions, swaps of neighbours) that turn a into b: the optimal string
// alignment distance (Damerau 1964). Upper and lower case count as equal. O(|a| |b|).
int edit_distance(std::string_view a, std::string_view b);

// The word a person most likely meant: at most a third of its letters (at least one, at most three) edited.
// The first of equally near ones; else the only word that begins with it. Words over 64 characters are
// nobody's near miss.
std::optional<std::string> near_miss(std::string_view word, std::span<const std::string> known);

// ": did you mean 'x'?", or "" without a near miss.
std::string did_you_mean(std::string_view word, std::span<const std::string> known);

// "a, b, c"; after `limit` words "and N more".
std::string join_words(std::span<const std::string> words, std::size_t limit = 16);

}  // namespace evograsp

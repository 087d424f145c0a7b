#include "common/near_miss.h"

#include <algorithm>

namespace evograsp {
namespace {

constexpr std::size_t kLongestWord = 64;

char lower(char c) {
  return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
}

// The one word that begins like this; nothing when there are several.
std::optional<std::string> only_completion(std::string_view word, std::span<const std::string> known) {
  const auto begins = [word](const std::string& candidate) { return candidate.starts_with(word); };
  if (word.size() < 3 || std::ranges::count_if(known, begins) != 1) return std::nullopt;
  return *std::ranges::find_if(known, begins);
}

}  // namespace

int edit_distance(std::string_view a, std::string_view b) {
  const std::size_t width = b.size() + 1;
  std::vector<int> before(width), previous(width), row(width);
  for (std::size_t j = 0; j < width; ++j) previous[j] = static_cast<int>(j);
  for (std::size_t i = 1; i <= a.size(); ++i) {
    row[0] = static_cast<int>(i);
    for (std::size_t j = 1; j < width; ++j) {
      const int substitution = previous[j - 1] + (lower(a[i - 1]) == lower(b[j - 1]) ? 0 : 1);
      row[j] = std::min({previous[j] + 1, row[j - 1] + 1, substitution});
      const bool swapped =
          i > 1 && j > 1 && lower(a[i - 1]) == lower(b[j - 2]) && lower(a[i - 2]) == lower(b[j - 1]);
      if (swapped) row[j] = std::min(row[j], before[j - 2] + 1);
    }
    before.swap(previous);
    previous.swap(row);
  }
  return previous[b.size()];
}

std::optional<std::string> near_miss(std::string_view word, std::span<const std::string> known) {
  if (word.empty() || word.size() > kLongestWord) return std::nullopt;
  const int allowed = std::clamp(static_cast<int>(word.size()) / 3, 1, 3);
  int best = allowed + 1;
  const std::string* found = nullptr;
  for (const std::string& candidate : known) {
    if (candidate.size() > kLongestWord) continue;
    const int distance = edit_distance(word, candidate);
    if (distance < best) {
      best = distance;
      found = &candidate;
    }
  }
  if (found != nullptr) return *found;
  return only_completion(word, known);
}

std::string did_you_mean(std::string_view word, std::span<const std::string> known) {
  const auto meant = near_miss(word, known);
  return meant ? ": did you mean '" + *meant + "'?" : "";
}

std::string join_words(std::span<const std::string> words, std::size_t limit) {
  std::string out;
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (i == limit) return out + " and " + std::to_string(words.size() - limit) + " more";
    if (i > 0) out += ", ";
    out += words[i];
  }
  return out;
}

}  // namespace evograsp

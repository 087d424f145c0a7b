// Tables of data: what a study measured, and how it is summed up.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "proto/study.pb.h"

namespace evograsp::cli::study {

using Cell = nlohmann::ordered_json;  // null: not known

struct DataTable {
  std::vector<std::string> columns;
  std::vector<std::vector<Cell>> rows;  // a cell a column

  int find(const std::string& column) const;                         // -1: there is none
  const Cell& at(std::size_t row, const std::string& column) const;  // null where there is no such column
};

// RFC 4180; unknown cells are empty. Ends with a newline.
std::string to_csv(const DataTable& table);
// An array with an object a row.
nlohmann::ordered_json to_json(const DataTable& table);

// true, false, whole numbers and fractions as such, else the text.
Cell cell_of(const std::string& name);
// A name as it was before cell_of; a number as people write it.
std::string text_of(const Cell& cell);
double number_of(const Cell& cell);  // NaN: is none

// ---- sums ----

// Of the finite ones; NaN when there are none. Quantiles by linear interpolation between order statistics
// (Hyndman and Fan 1996, type 7).
double quantile(std::vector<double> values, double part);
double median(const std::vector<double>& values);
double mean(const std::vector<double>& values);
double summary(const std::vector<double>& values, proto::StudySummary how);

struct Range {
  double low = 0, high = 0;
};
// Of the median, free of any distribution: the narrowest pair of order statistics, placed symmetrically, that
// holds it with 95 % confidence (binomial with p = 1/2); with fewer than six values the whole range, which
// holds it with 94 % for five. NaN for none.
Range median_interval(std::vector<double> values);

// Rows grouped by equal cells of `by`, groups in the order of their first rows.
struct Group {
  std::vector<Cell> key;
  std::vector<std::size_t> rows;
};
std::vector<Group> group(const DataTable& table, const std::vector<std::string>& by);
// The finite numbers of a column, in these rows.
std::vector<double> numbers(const DataTable& table, const std::vector<std::size_t>& rows,
                            const std::string& column);

}  // namespace evograsp::cli::study

#include "cli/study/report.h"

#include <cmath>
#include <cstdio>

#include "cli/inputs.h"
#include "cli/page.h"
#include "cli/study/figures.h"
#include "common/version.h"

namespace evograsp::cli::study {
namespace {

namespace fs = std::filesystem;

std::string shown(const Cell& cell, const proto::StudyColumn& column) {
  const double value = number_of(cell);
  if (!std::isfinite(value)) return cell.is_null() ? "-" : text_of(cell);
  char text[64];
  std::snprintf(text, sizeof text, "%.*f%s", static_cast<int>(column.digits()),
                (column.percent() ? 100 : 1) * value, column.percent() ? " %" : "");
  return text;
}

PageTable page_table(const proto::Study& study, const SummedTable& summed) {
  const proto::StudyTable& spec = *summed.spec;
  PageTable page;
  page.words = static_cast<std::size_t>(spec.by_size());
  for (const std::string& by : spec.by()) page.columns.push_back(by);
  for (const proto::StudyColumn& column : spec.column())
    page.columns.push_back(column.has_label() ? column.label() : column.name());
  const bool references = spec.reference_size() > 0;
  if (references) page.columns.push_back(spec.reference_label());
  std::vector<std::vector<Cell>> rows = summed.data.rows;
  rows.insert(rows.end(), summed.means.begin(), summed.means.end());
  for (const auto& cells : rows) {
    std::vector<std::string> row;
    std::size_t at = 0;
    for (const std::string& by : spec.by()) row.push_back(label_of(study, by, text_of(cells[at++])));
    for (const proto::StudyColumn& column : spec.column()) row.push_back(shown(cells[at++], column));
    // References are in the units of the first column.
    if (references)
      row.push_back(spec.column_size() > 0 ? shown(cells.back(), spec.column(0)) : text_of(cells.back()));
    page.rows.push_back(std::move(row));
  }
  return page;
}

class ReportWriter {
 public:
  ReportWriter(const LoadedStudy& study, const Data& data, const Report& report)
      : study_(study), data_(data), report_(report) {}
  Status write();

 private:
  Status write_table(const std::string& name, const DataTable& table);
  Status add_table(const proto::StudyTable& spec);
  Status add_plot(const proto::StudyPlot& plot);
  void add_head();
  void add_foot();

  const LoadedStudy& study_;
  const Data& data_;
  const Report& report_;
  Page page_;
};

Status ReportWriter::write_table(const std::string& name, const DataTable& table) {
  if (auto status = write_file(report_.out / (name + ".csv"), to_csv(table)); !status) return status;
  // A row a line: small, and differences of two versions can be read.
  std::string text = "[";
  for (const auto& row : to_json(table))
    text += (text.size() > 1 ? ",\n " : "\n ") + row.dump(-1, ' ', false, Cell::error_handler_t::replace);
  return write_file(report_.out / (name + ".json"), text + "\n]\n");
}

Status ReportWriter::add_table(const proto::StudyTable& spec) {
  const SummedTable summed = sum_up(spec, data_);
  if (auto status = write_table(spec.name(), summed.data); !status) return status;
  if (spec.has_title()) page_.parts.push_back(PageHeading{2, spec.title()});
  page_.parts.push_back(page_table(study_.study, summed));
  return {};
}

Status ReportWriter::add_plot(const proto::StudyPlot& plot) {
  const Figure figure = figure_of(study_.study, plot, data_);
  const auto svg = to_svg(figure);
  if (!svg) return tl::unexpected(svg.error());
  if (auto status = write_file(report_.out / (plot.name() + ".svg"), *svg); !status) return status;
  if (auto status = write_png(figure, report_.out / (plot.name() + ".png")); !status) return status;
  const std::string how =
      plot.kind() == proto::BARS
          ? "Bars: median over the seeds; dots: single seeds; whiskers: 95 % interval of the median "
            "(the whole range when there are fewer than six seeds)."
          : "Lines: median over the seeds; bands: lower to upper quartile.";
  page_.parts.push_back(PageFigure{plot.name() + ".svg", *svg, plot.title(),
                                   (plot.has_caption() ? plot.caption() + " " : "") + how});
  return {};
}

void ReportWriter::add_head() {
  page_.title = study_.study.title();
  for (const std::string& paragraph : study_.study.text()) page_.parts.push_back(PageText{paragraph});
  const std::size_t done = data_.runs.rows.size();
  std::string counted = std::to_string(done) + " runs";
  if (done < report_.planned)
    counted = std::to_string(done) + " of " + std::to_string(report_.planned) + " runs so far";
  page_.parts.push_back(PageText{counted + " by evograsp " + kVersion + ":"});
  page_.parts.push_back(PageCode{report_.command});
  if (const auto notes = read_file(report_.out / "notes.md")) {
    for (PagePart& part : parse_markdown(*notes)) page_.parts.push_back(std::move(part));
  }
}

void ReportWriter::add_foot() {
  page_.parts.push_back(PageHeading{2, "Data"});
  std::string files =
      "Each as CSV and as JSON: `runs` (a row a run), `tests` (a row an object that a champion was tested "
      "on), `generations` (a row a generation)";
  for (const proto::StudyTable& table : study_.study.table()) files += ", `" + table.name() + "`";
  page_.parts.push_back(PageText{files + "."});
}

Status ReportWriter::write() {
  add_head();
  if (auto status = write_table("runs", data_.runs); !status) return status;
  if (auto status = write_table("tests", data_.tests); !status) return status;
  if (auto status = write_table("generations", data_.generations); !status) return status;
  for (const proto::StudyTable& spec : study_.study.table())
    if (auto status = add_table(spec); !status) return status;
  for (const proto::StudyPlot& plot : study_.study.plot())
    if (auto status = add_plot(plot); !status) return status;
  add_foot();
  if (auto status = write_file(report_.out / "README.md", to_markdown(page_)); !status) return status;
  return write_file(report_.out / "report.html", to_html(page_));
}

}  // namespace

Status write_report(const LoadedStudy& study, const Data& data, const Report& report) {
  return ReportWriter(study, data, report).write();
}

}  // namespace evograsp::cli::study

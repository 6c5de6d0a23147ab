#include <palpate/report/run_figures.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <utility>

namespace palpate {
namespace {

using Value = std::function<double(const RunRow&)>;
/// True if rows of that run have a value; the columns of a run are those of its first row.
using Has = bool (*)(const RunRow&);

constexpr std::size_t kColumns = 600;  // intervals of a line
constexpr double kLeastTime = 0.1;     // shown for 0 on a logarithmic axis. Unit: [us].
constexpr std::array kAxes{"x", "y", "z"};

double count(std::size_t n) { return std::max(PlotAxis::kLeastCount, static_cast<double>(n)); }
double contacts(const RunRow& row) { return count(row.colliding); }
double compute(const RunRow& row) { return std::max(kLeastTime, row.compute_us); }
Eigen::Vector3d force(const RunRow& row) { return row.wrench.force; }
bool always(const RunRow&) { return true; }
bool has_user(const RunRow& row) { return row.user_force.has_value(); }
Eigen::Vector3d user(const RunRow& row) { return *row.user_force; }
bool has_sent(const RunRow& row) { return row.live.has_value(); }
Eigen::Vector3d sent(const RunRow& row) { return row.live->sent.force; }

std::string name_of(const Run& run) { return std::filesystem::path(run.source).filename().string(); }

/// Line of the largest and the least value of each interval of rows, so that no spike is lost.
PlotSeries line(const Run& run, const std::string& name, int color, const Value& value) {
  PlotSeries drawn{name, PlotSeries::Style::kLine, color % PlotSeries::kColors, {}};
  const std::size_t size = run.rows.size(), each = std::max<std::size_t>(1, size / kColumns);
  for (std::size_t first = 0; first < size; first += each) {
    const auto begin = run.rows.begin() + static_cast<std::ptrdiff_t>(first);
    const auto end = run.rows.begin() + static_cast<std::ptrdiff_t>(std::min(size, first + each));
    auto [low, high] = std::minmax_element(
        begin, end, [&](const RunRow& a, const RunRow& b) { return value(a) < value(b); });
    if (high < low) std::swap(low, high);
    drawn.points.emplace_back(low->t, value(*low));
    if (high != low) drawn.points.emplace_back(high->t, value(*high));
  }
  return drawn;
}

class RunPlots {
 public:
  /// \pre not empty, nor is any of the runs
  explicit RunPlots(const std::vector<Run>& runs) : runs_(runs) {
    for (const Run& run : runs) of_ += (of_.empty() ? "" : ", ") + name_of(run);
  }

  Plot counts() const {
    Plot plot = over_time("counts", "Collision count", {"Gaussians", true, PlotAxis::kLeastCount, {}, {}});
    if (runs_.size() > 1) return with_lines(std::move(plot), contacts);
    const Run& run = runs_.front();
    plot.series = {line(run, "candidates", 0, [](const RunRow& r) { return count(r.candidates); }),
                   line(run, "filtered", 2, [](const RunRow& r) { return count(r.filtered); }),
                   line(run, "colliding", 1, contacts)};
    return plot;
  }

  Plot times() const {
    Plot plot = over_time("compute", "Computation time", {"us", true, kLeastTime, {}, {}});
    return with_lines(std::move(plot), compute);
  }

  Plot vector(const std::string& name, const std::string& title, Eigen::Vector3d (*of)(const RunRow&),
              Has has) const {
    const bool several = runs_.size() > 1;
    Plot plot = over_time(name, title, {several ? "magnitude, N" : "N", false, {}, {}, {}});
    if (several)
      return with_lines(
          std::move(plot), [=](const RunRow& row) { return of(row).norm(); }, has);
    for (int axis = 0; axis < 3; ++axis) {
      plot.series.push_back(line(runs_.front(), kAxes[static_cast<std::size_t>(axis)], axis,
                                 [=](const RunRow& row) { return of(row)[axis]; }));
    }
    plot.series.push_back(
        line(runs_.front(), "magnitude", 3, [=](const RunRow& row) { return of(row).norm(); }));
    return plot;
  }

  bool any(Has has) const {
    return std::any_of(runs_.begin(), runs_.end(), [&](const Run& run) { return has(run.rows.front()); });
  }

 private:
  Plot over_time(const std::string& name, const std::string& title, PlotAxis y) const {
    return {name, title, of_, {"time, s", false, {}, {}, {}}, std::move(y), {}};
  }

  Plot with_lines(Plot plot, const Value& value, Has has = always) const {
    for (std::size_t i = 0; i < runs_.size(); ++i)
      if (has(runs_[i].rows.front()))
        plot.series.push_back(line(runs_[i], name_of(runs_[i]), static_cast<int>(i), value));
    return plot;
  }

  const std::vector<Run>& runs_;
  std::string of_;
};

}  // namespace

std::vector<Plot> run_figures(const std::vector<Run>& runs) {
  const RunPlots figures(runs);
  std::vector<Plot> plots{figures.counts(), figures.vector("force", "Repulsive force", force, always)};
  if (figures.any(has_user)) plots.push_back(figures.vector("user", "User force", user, has_user));
  if (figures.any(has_sent)) plots.push_back(figures.vector("sent", "Force sent", sent, has_sent));
  plots.push_back(figures.times());
  return plots;
}

}  // namespace palpate

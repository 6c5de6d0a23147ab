#include <palpate/report/run_table.h>

#include <algorithm>
#include <cstddef>

#include <fmt/format.h>

namespace palpate {
namespace {

std::string episodes_text(const std::vector<RunRow>& rows) {
  constexpr std::size_t kShown = 30;
  const auto episodes = contact_episodes(rows);
  if (episodes.empty()) {
    return "no contact\n";
  }
  std::string text = fmt::format("{:>7} {:>9} {:>10} {:>9} {:>11}  {}\n", "contact", "onset s", "duration s",
                                 "colliding", "max |F| N", "tool at onset, m");
  for (std::size_t k = 0; k < std::min(kShown, episodes.size()); ++k) {
    const Episode& e = episodes[k];
    const Eigen::Vector3d& p = rows[e.first].tool.position;
    text += fmt::format("{:>7} {:>9.3f} {:>10.3f} {:>9} {:>11.3f}  {:.4f} {:.4f} {:.4f}\n", k + 1,
                        rows[e.first].t, rows[e.last].t - rows[e.first].t, e.most_colliding, e.peak_force,
                        p.x(), p.y(), p.z());
  }
  if (episodes.size() > kShown) text += fmt::format("  ... and {} more\n", episodes.size() - kShown);
  return text;
}

}  // namespace

OrderedJson run_json(const std::vector<RunRow>& rows) {
  const RunSummary summary = summarize(rows);
  return {
      {"poses", rows.size()},
      {"seconds", summary.seconds},
      {"contact_poses", summary.contact_rows},
      {"episodes", contact_episodes(rows).size()},
      {"colliding_max", summary.most_colliding},
      {"force_max", summary.largest_force},
      {"compute_us",
       {{"p50", summary.compute_us.p50}, {"p99", summary.compute_us.p99}, {"max", summary.compute_us.max}}}};
}

std::string run_text(const std::vector<RunRow>& rows) {
  const RunSummary s = summarize(rows);
  return episodes_text(rows) + fmt::format(
                                   "\n{} poses over {:.2f} s, {} in contact; at most {} colliding "
                                   "Gaussians and {:.2f} N; computation time p50 {:.1f} us, "
                                   "p99 {:.1f} us, max {:.0f} us\n",
                                   rows.size(), s.seconds, s.contact_rows, s.most_colliding, s.largest_force,
                                   s.compute_us.p50, s.compute_us.p99, s.compute_us.max);
}

}  // namespace palpate

#include <palpate/report/pose_table.h>

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace palpate {
namespace {

/// Lists contacts in decreasing order of K_min, as many as fit a screen.
std::string contacts_text(std::vector<PoseContact> rows) {
  constexpr std::size_t kShown = 20;
  std::sort(rows.begin(), rows.end(),
            [](const PoseContact& a, const PoseContact& b) { return a.contact.k_min > b.contact.k_min; });
  if (rows.empty()) return {};
  std::string text = fmt::format("\n{:>10} {:>8} {:>8} {:>8} {:>9} {:>10}  {:<30} {}\n", "id", "K_min",
                                 "lambda", "opacity", "depth mm", "confidence", "point m", "normal");
  for (std::size_t i = 0; i < std::min(kShown, rows.size()); ++i) {
    const Contact& c = rows[i].contact;
    text += fmt::format("{:>10} {:>8.5f} {:>8.5f} {:>8.3f} {:>9.3f} {:>10}  {:<30} {:.3f} {:.3f} {:.3f}\n",
                        c.id, c.k_min, c.lambda, c.opacity, 1e3 * c.depth,
                        std::isnan(rows[i].confidence) ? "-" : fmt::format("{:.3f}", rows[i].confidence),
                        fmt::format("{:.5f} {:.5f} {:.5f}", c.point.x(), c.point.y(), c.point.z()),
                        c.normal.x(), c.normal.y(), c.normal.z());
  }
  if (rows.size() > kShown)
    text += fmt::format("  ... and {} more; --json lists all\n", rows.size() - kShown);
  return text;
}

}  // namespace

OrderedJson pose_json(PoseReport answer) {
  // The order of the scene file, independent of the index that found them.
  std::stable_sort(answer.rows.begin(), answer.rows.end(),
                   [](const PoseContact& a, const PoseContact& b) { return a.contact.id < b.contact.id; });
  OrderedJson json{
      {"candidates", answer.candidates}, {"filtered", answer.filtered}, {"contacts", OrderedJson::array()}};
  for (const PoseContact& row : answer.rows) {
    const Contact& c = row.contact;
    json["contacts"].push_back({{"id", c.id},
                                {"k_min", c.k_min},
                                {"lambda", c.lambda},
                                {"opacity", c.opacity},
                                {"center", vector_json(c.center)},
                                {"point", vector_json(c.point)},
                                {"normal", vector_json(c.normal)},
                                {"depth", c.depth},
                                {"part", *row.part},
                                {"confidence", row.confidence}});  // NaN is written as null
  }
  json["force"] = vector_json(answer.felt.wrench.force);
  json["torque"] = vector_json(answer.felt.wrench.torque);
  json["confidence"] = answer.felt.confidence;
  return json;
}

std::string pose_text(const PoseReport& answer, std::string_view model) {
  std::string text;
  const Wrench& wrench = answer.felt.wrench;
  text += fmt::format("{} candidates, {} after bounding-sphere test, {} in contact\n", answer.candidates,
                      answer.filtered, answer.rows.size());
  text += fmt::format("force  {:.4f} {:.4f} {:.4f} N, |F| = {:.4f} N ({})\n", wrench.force.x(),
                      wrench.force.y(), wrench.force.z(), wrench.force.norm(), model);
  text += fmt::format("torque {:.5f} {:.5f} {:.5f} N m\n", wrench.torque.x(), wrench.torque.y(),
                      wrench.torque.z());
  return text + contacts_text(answer.rows);
}

}  // namespace palpate

#include <support/brute_force.h>

#include <algorithm>
#include <atomic>
#include <cmath>

#include <gtest/gtest.h>

namespace palpate::test {
namespace {

std::atomic<double> worst_k = 0.0, worst_place = 0.0;

void note(std::atomic<double>& worst, double value) {
  double seen = worst;
  while (value > seen && !worst.compare_exchange_weak(seen, value)) {
  }
}

/// False if the bounding spheres are apart by more than any rounding.
bool within_reach(const Ellipsoid& tool, const Ellipsoid& gaussian) {
  const double reach = (1.0 + 1e-6) * (tool.radius() + gaussian.radius());
  return (tool.center - gaussian.center).norm() <= reach;
}

double k_min_of(const EllipsoidScene& scene, std::uint32_t id, const Ellipsoid& tool) {
  const auto found = std::lower_bound(scene.id.begin(), scene.id.end(), id);
  if (found == scene.id.end() || *found != id) return -1.0;  // not a Gaussian that is kept
  const auto i = static_cast<std::size_t>(found - scene.id.begin());
  return minimize(KFunction(WhitenedTool(tool), scene.ellipsoids[i])).k_min;
}

void expect_close(const Contact& found, const Contact& expected, const Ellipsoid& tool, const Bars& bars) {
  const double away = expected.center.norm() + tool.center.norm() + bars.away;
  const double size = tool.radius();
  EXPECT_NEAR(found.k_min, expected.k_min, bars.k);
  EXPECT_NEAR(found.opacity, expected.opacity, 1e-14);
  EXPECT_LE((found.center - expected.center).norm(), 1e-15 * away + 1e-13 * size);
  EXPECT_NEAR(found.normal.norm(), 1.0, 1e-9);
  EXPECT_TRUE(found.point.allFinite() && std::isfinite(found.depth));
  EXPECT_TRUE(found.lambda >= 0.0 && found.lambda <= 1.0) << found.lambda;
  if (bars.k <= Bars().k) note(worst_k, std::abs(found.k_min - expected.k_min));
  if (bars.place == 0.0) return;
  const double rounding = 1e-14 * away / size;
  const double differences[] = {std::abs(found.lambda - expected.lambda),
                                (found.normal - expected.normal).norm(),
                                (found.point - expected.point).norm() / size - rounding,
                                std::abs(found.depth - expected.depth) / size - rounding};
  for (const double difference : differences) {
    EXPECT_LE(difference, bars.place) << "lambda, normal, point, depth: number " << &difference - differences;
    if (bars.k <= Bars().k) note(worst_place, difference);
  }
}

}  // namespace

std::vector<Contact> in_order(std::vector<Contact> contacts) {
  const auto less = [](const Contact& a, const Contact& b) { return a.id < b.id; };
  std::sort(contacts.begin(), contacts.end(), less);
  const auto same = [](const Contact& a, const Contact& b) { return a.id == b.id; };
  EXPECT_EQ(std::adjacent_find(contacts.begin(), contacts.end(), same), contacts.end()) << "a contact twice";
  return contacts;
}

std::vector<Contact> brute_force(const EllipsoidScene& scene, const Ellipsoid& tool) {
  const WhitenedTool whitened(tool);
  std::vector<Contact> contacts;
  for (std::size_t i = 0; i < scene.size(); ++i) {
    if (!within_reach(tool, scene.ellipsoids[i])) continue;
    const KFunction k(whitened, scene.ellipsoids[i]);
    const KMinimum minimum = minimize(k);
    if (!(minimum.k_min > 0.0)) continue;
    contacts.push_back(make_contact(whitened, scene.ellipsoids[i], k, minimum));
    contacts.back().id = scene.id[i];
    contacts.back().opacity = scene.opacity[i];
  }
  return contacts;
}

void expect_close(const std::vector<Contact>& found, const std::vector<Contact>& expected,
                  const Ellipsoid& tool, const Bars& bars) {
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    ASSERT_EQ(found[i].id, expected[i].id);
    expect_close(found[i], expected[i], tool, bars);
  }
}

void expect_equal(const std::vector<Contact>& found, const std::vector<Contact>& expected) {
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    ASSERT_EQ(found[i].id, expected[i].id);
    ASSERT_EQ(found[i].k_min, expected[i].k_min);
    ASSERT_EQ(found[i].lambda, expected[i].lambda);
    ASSERT_EQ(found[i].opacity, expected[i].opacity);
    ASSERT_EQ(found[i].center, expected[i].center);
    ASSERT_EQ(found[i].point, expected[i].point);
    ASSERT_EQ(found[i].normal, expected[i].normal);
    ASSERT_EQ(found[i].depth, expected[i].depth);
  }
}

BruteForce::BruteForce(const GaussianScene& scene, const SceneFilter& filter,
                       const Similarity& world_from_scene, std::vector<Ellipsoid> tools)
    : tools_(std::move(tools)) {
  FilterReport report;
  scene_ = filter_scene(scene, filter, world_from_scene, report);
  for (const Ellipsoid& tool : tools_) contacts_.push_back(brute_force(scene_, tool));
}

std::size_t BruteForce::check(const ContactQuery& query, const Bars& bars) const {
  std::size_t seen = 0;
  ContactSet set;
  for (std::size_t i = 0; i < tools_.size(); ++i) {
    SCOPED_TRACE(testing::Message() << "tool " << i);
    query.query(tools_[i], set);
    check_verdicts(in_order(set.contacts), i, bars);
    EXPECT_LE(set.filtered, set.candidates);
    EXPECT_LE(set.contacts.size(), set.filtered);
    EXPECT_LE(set.candidates, scene_.size());
    seen += set.contacts.size();
    if (testing::Test::HasFailure()) break;
  }
  return seen;
}

void BruteForce::check_verdicts(const std::vector<Contact>& found, std::size_t tool, const Bars& bars) const {
  const std::vector<Contact>& expected = contacts_[tool];
  auto f = found.begin();
  auto e = expected.begin();
  while (f != found.end() || e != expected.end()) {
    if (f != found.end() && e != expected.end() && f->id == e->id) {
      expect_close(*f, *e, tools_[tool], bars);
      ++f;
      ++e;
    } else if (e == expected.end() || (f != found.end() && f->id < e->id)) {
      EXPECT_GT(k_min_of(scene_, f->id, tools_[tool]), -bars.k) << "an extra contact, id " << f->id;
      ++f;
    } else {
      EXPECT_LT(e->k_min, bars.k) << "a missed contact, id " << e->id;
      ++e;
    }
  }
}

WorstSeen worst_seen() { return {worst_k, worst_place}; }

}  // namespace palpate::test

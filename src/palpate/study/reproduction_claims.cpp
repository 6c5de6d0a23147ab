#include <palpate/study/reproduction_claims.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <utility>

#include <palpate/base/quantile.h>

namespace palpate {
namespace {

using Eigen::Vector3d;
using Bound = Claim::Bound;

constexpr double kNotMeasured = std::numeric_limits<double>::quiet_NaN();
constexpr double kMilli = 1e-3;
/// Beginning of a contact in which computation must be quick. Unit: [s].
constexpr double kFirst = 0.1;
/// Least change of a force's direction that a person notices. Unit: [deg].
constexpr double kNoticed = 18.0;
/// Largest swing of a tool at rest. Unit: [m].
constexpr double kAtRest = 5e-5;

template <class Value>
std::vector<double> values_of(const ReproductionRun& run, const Value& value) {
  std::vector<double> values;
  for (const ReproductionTick& tick : run.ticks) {
    const double v = value(tick);
    if (!std::isnan(v)) values.push_back(v);
  }
  return values;
}

/// The q-quantile; NaN if nothing was measured.
double measured_quantile(std::vector<double> values, double q) {
  return values.empty() ? kNotMeasured : quantile(values, q);
}

template <class Value>
double most(const ReproductionRun& run, const Value& value) {
  return measured_quantile(values_of(run, value), 1.0);
}

double mean(const std::vector<double>& values) {
  if (values.empty()) return kNotMeasured;
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

std::vector<double> ranks(const std::vector<double>& values) {
  std::vector<std::size_t> order(values.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return values[a] < values[b]; });
  std::vector<double> rank(values.size());
  for (std::size_t i = 0; i < order.size();) {
    std::size_t j = i;
    while (j < order.size() && values[order[j]] == values[order[i]]) ++j;
    for (std::size_t k = i; k < j; ++k) rank[order[k]] = 0.5 * static_cast<double>(i + j - 1);
    i = j;
  }
  return rank;
}

/// Spearman's rank correlation; NaN if one of them does not vary.
double rank_correlation(const std::vector<double>& a, const std::vector<double>& b) {
  if (a.size() < 2) return kNotMeasured;
  const std::vector<double> x = ranks(a), y = ranks(b);
  const double mx = mean(x), my = mean(y);
  double xy = 0.0, xx = 0.0, yy = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    xy += (x[i] - mx) * (y[i] - my);
    xx += (x[i] - mx) * (x[i] - mx);
    yy += (y[i] - my) * (y[i] - my);
  }
  return xx > 0.0 && yy > 0.0 ? xy / std::sqrt(xx * yy) : kNotMeasured;
}

/// Rank correlation of collision count and force while the hand presses, mean of all places: places differ in
/// the density of the scene.
double grows_with_count(const ReproductionRun& run, const RoomPath& path) {
  std::vector<double> all;
  for (const RoomTouch& touch : path.touches) {
    std::vector<double> count, force;
    for (const ReproductionTick& tick : run.ticks) {
      if (tick.colliding == 0 || tick.t < touch.begins || tick.t > touch.pressed) continue;
      count.push_back(static_cast<double>(tick.colliding));
      force.push_back(tick.felt.norm());
    }
    const double correlation = rank_correlation(count, force);
    if (!std::isnan(correlation)) all.push_back(correlation);
  }
  return mean(all);
}

double felt_contacts(const ReproductionRun& run) {
  return static_cast<double>(
      std::count_if(run.contacts.begin(), run.contacts.end(),
                    [](const ReproductionContact& c) { return !std::isnan(c.begins); }));
}

/// Area of the bounding rectangle of the tool's path. Unit: [m^2].
double area(const ReproductionRun& run) {
  Eigen::AlignedBox2d box;
  for (const ReproductionTick& tick : run.ticks) box.extend(tick.tool.head<2>());
  return box.volume();
}

double single_share(const ReproductionRun& run) {
  const double largest = most(run, [](const ReproductionTick& tick) { return tick.felt.norm(); });
  return mean(values_of(run, [&](const ReproductionTick& tick) {
    return tick.colliding == 1 ? tick.felt.norm() / largest : kNotMeasured;
  }));
}

double degrees_off(const ReproductionRun& run) {
  double worst = kNotMeasured;
  for (const ReproductionContact& contact : run.contacts)
    worst = std::fmax(worst, contact.off * 180.0 / std::numbers::pi);
  return worst;
}

/// Largest force without contact, which begins with a collision and lasts until a tick without force: a tool
/// behind a thin layer whose proxy stays in front of it is still in contact.
double without_contact(const ReproductionRun& run) {
  double largest = 0.0;
  bool contact = false;
  for (const ReproductionTick& tick : run.ticks) {
    contact = tick.colliding > 0 || (contact && !tick.felt.isZero(0.0));
    if (!contact) largest = std::max(largest, tick.felt.norm());
  }
  return largest;
}

/// Least user force at rest of all contacts, over the median of the user force without contact.
double spike(const ReproductionRun& run) {
  const double usual = measured_quantile(
      values_of(run,
                [&](const ReproductionTick& tick) {
                  return tick.colliding == 0 && tick.force.isZero(0.0) ? tick.user.norm() : kNotMeasured;
                }),
      0.5);
  double least = kNotMeasured;
  for (const ReproductionContact& contact : run.contacts) least = std::fmin(least, contact.user);
  return usual > 0.0 ? least / usual : kNotMeasured;
}

double oscillating(const ReproductionRun& run) {
  return static_cast<double>(
      std::count_if(run.contacts.begin(), run.contacts.end(),
                    [](const ReproductionContact& c) { return c.bounces > 0 || c.swing > kAtRest; }));
}

double cpu_ms(const ReproductionTick& tick) { return kMilli * tick.cpu_us; }

double first_ms(const ReproductionRun& run) {
  std::vector<double> times;
  for (const ReproductionTick& tick : run.ticks) {
    for (const ReproductionContact& contact : run.contacts) {
      if (tick.t >= contact.begins && tick.t < contact.begins + kFirst) times.push_back(cpu_ms(tick));
    }
  }
  return measured_quantile(std::move(times), 0.95);
}

double cpu_quantile(const ReproductionRun& run, double q) {
  return measured_quantile(values_of(run, cpu_ms), q);
}

}  // namespace

double Claim::ratio(double value) const {
  if (limit == 0.0 || value == 0.0 || std::isnan(value)) return kNotMeasured;
  return bound == Bound::kAtMost ? limit / value : value / limit;
}

std::vector<Claim> claims(std::size_t gaussians, std::size_t kept, const RoomPath& path,
                          const ReproductionRun& paper, const ReproductionRun& own) {
  std::vector<Claim> all;
  const auto add = [&](const char* words, const char* figure, const char* what, Bound bound, double limit,
                       const auto& value) {
    all.push_back({words, figure, what, bound, limit, value(paper), value(own)});
  };
  const auto millions = [](std::size_t n) { return 1e-6 * static_cast<double>(n); };
  add("The original model contains 2.5 million Gaussians", "2.5 million", "Gaussians, millions",
      Bound::kAtLeast, 2.5, [&](const auto&) { return millions(gaussians); });
  add("... reduced to 1 million after opacity filtering", "1 million", "kept Gaussians, millions",
      Bound::kAtLeast, 1.0, [&](const auto&) { return millions(kept); });
  add("In the area of 2.0 m times 3.0 m", "6 m^2", "bounding area of the path, m^2", Bound::kAtLeast, 6.0,
      area);
  // Of any path: one with fewer places does not show what the statement says.
  add("Seven contact points are created", "7", "contacts with a force", Bound::kAtLeast, 7.0, felt_contacts);
  add("The kd-tree identifies sets of candidates that contain less than 500 ellipsoids", "< 500",
      "largest number of candidates", Bound::kAtMost, 500.0, [](const auto& run) {
        return most(run, [](const auto& t) { return static_cast<double>(t.candidates); });
      });
  add("Each contact can contain up to 100 colliding ellipsoids", "100",
      "largest number of colliding Gaussians", Bound::kAtLeast, 100.0, [](const auto& run) {
        return most(run, [](const auto& t) { return static_cast<double>(t.colliding); });
      });
  add("No repulsion is calculated without contact", "0 N", "largest force without contact, N", Bound::kAtMost,
      0.0, without_contact);
  add("Already single collisions result in low repulsive forces", "-",
      "mean force at a single collision over the largest force (criterion: at most 0.1)", Bound::kAtMost, 0.1,
      single_share);
  add("With increasing collision count, the repulsive force also increases", "-",
      "rank correlation of count and force while pressing, mean of all places (criterion: at least 0.5)",
      Bound::kAtLeast, 0.5, [&](const auto& run) { return grows_with_count(run, path); });
  add("The direction depends on the geometry of the object", "-",
      "worst angle of the force to the true normal at rest, degrees (criterion: at most 18, the perception "
      "threshold)",
      Bound::kAtMost, kNoticed, degrees_off);
  add("Contact points are characterised by significant spikes of the user force", "-",
      "smallest ratio of user force in contact to that in free motion (criterion: at least 2)",
      Bound::kAtLeast, 2.0, spike);
  add("At t_a and t_g a small oscillatory behaviour can be observed", "2 of 7",
      "contacts with a rebound, or an oscillation above 0.05 mm at rest", Bound::kAtMost, 2.0, oscillating);
  add("The overlap computation requires up to 50 ms", "50 ms", "longest computation of a tick, ms",
      Bound::kAtMost, 50.0, [](const auto& run) { return most(run, cpu_ms); });
  add("In the first contact points computation time remains mainly below 1 ms", "1 ms",
      "computation time in the first 0.1 s of each contact, p95, ms", Bound::kAtMost, 1.0, first_ms);
  add("The control frequency is 1 kHz", "1 ms", "computation time, p99.9 of all ticks, ms", Bound::kAtMost,
      1.0, [](const auto& run) { return cpu_quantile(run, 0.999); });
  return all;
}

}  // namespace palpate

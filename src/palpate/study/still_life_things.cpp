#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include <palpate/study/solid_noise.h>
#include <palpate/study/still_life_parts.h>

namespace palpate::still_life {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using std::numbers::pi;

/// 1 in the middle of a groove, 0 from `half_width` on.
double groove(double off, double half_width) { return 1.0 - smooth(0.0, half_width, std::abs(off)); }

double box_distance(const Vector3d& p, const Vector3d& half) {
  const Vector3d off = p.cwiseAbs() - half;
  return off.cwiseMax(0.0).norm() + std::min(off.maxCoeff(), 0.0);
}

/// Signed distance to a cylinder about z.
double cylinder_distance(const Vector3d& p, double radius, double half_height) {
  const Vector2d off(std::hypot(p.x(), p.y()) - radius, std::abs(p.z()) - half_height);
  return off.cwiseMax(0.0).norm() + std::min(off.maxCoeff(), 0.0);
}

Vector3d to_local(const Pose& pose, const Vector3d& p) {
  return pose.orientation.conjugate() * (p - pose.position);
}

// --- table

constexpr double kThickness = 0.028;  // Unit: [m].
constexpr double kEdge = 0.005;       // radius of its edges. Unit: [m].
constexpr double kCorner = 0.03;      // radius of its corners, seen from above. Unit: [m].
constexpr double kPlank = 2.0 * kTableHalfY / 4.0;
constexpr double kJoint = 0.0012;   // depth of the grooves between planks. Unit: [m].
constexpr double kGrain = 0.00025;  // Unit: [m].

double wood_grain(const Vector3d& p) {
  const double plank = std::floor((p.y() + kTableHalfY) / kPlank);
  const Vector3d q(2.2 * p.x() + 3.7 * plank, 26.0 * p.y(), 26.0 * p.z() + 11.0 * plank);
  return fractal_noise(q + Vector3d(0.0, 1.6 * solid_noise(2.0 * q, 41), 0.0), 4, 40);
}

double wood_joint(double y) {
  const double in_plank = (y + kTableHalfY) / kPlank;
  const double off = kPlank * (in_plank - std::round(in_plank));
  return std::abs(y) < kTableHalfY - 0.02 ? groove(off, 0.0022) : 0.0;
}

Paint wood(double, double, const Vector3d& p) {
  const double plank = std::floor((p.y() + kTableHalfY) / kPlank);
  const double grain = wood_grain(p);
  const double rings =
      0.5 +
      0.5 * std::sin(26.0 * fractal_noise(Vector3d(0.9 * p.x() + plank, 5.5 * p.y(), 3.0 * plank), 2, 43));
  Vector3d albedo =
      mixed(linear_color(0x9a6a3e), linear_color(0x6d4426), 0.45 * rings + 0.4 * std::max(0.0, grain));
  albedo *= 1.0 + 0.16 * solid_noise(Vector3d(plank, 3.0 * plank, 0.5), 44) + 0.10 * grain;
  return {mixed(albedo, linear_color(0x22150c), 0.85 * wood_joint(p.y())), 0.12};
}

/// True inside the outline of the table, whose corners are round, reduced by `inset`.
bool is_on_table(const Vector3d& p, double inset) {
  const Vector2d half(kTableHalfX - inset, kTableHalfY - inset);
  const double r = std::max(0.0, kCorner - inset);
  const Vector2d off = (Vector2d(std::abs(p.x()), std::abs(p.y())) - (half - Vector2d(r, r))).cwiseMax(0.0);
  return off.norm() <= r;
}

/// Point of that outline at the fraction `share` of its length, counter-clockwise.
Vector2d outline(double share, double inset) {
  const Vector2d half(kTableHalfX - inset, kTableHalfY - inset);
  const double r = std::max(1e-4, kCorner - inset);
  const Vector2d straight = half - Vector2d(r, r);
  const double arc = 0.5 * pi * r;
  double way = (share - std::floor(share)) * (4.0 * (straight.x() + straight.y()) + 4.0 * arc);
  const std::array<double, 4> sides{2.0 * straight.y(), 2.0 * straight.x(), 2.0 * straight.y(),
                                    2.0 * straight.x()};
  for (int k = 0; k < 4; ++k) {
    const double c = std::array{1.0, 0.0, -1.0, 0.0}[static_cast<std::size_t>(k)];
    const double s = std::array{0.0, 1.0, 0.0, -1.0}[static_cast<std::size_t>(k)];
    const auto turned = [&](double x, double y) { return Vector2d(c * x - s * y, s * x + c * y); };
    const double across = k % 2 == 0 ? half.x() : half.y();
    const double side = sides[static_cast<std::size_t>(k)];
    if (way <= side) return turned(across, way - 0.5 * side);
    way -= side;
    if (way <= arc) {
      const double angle = way / r;
      return turned(across - r + r * std::cos(angle), 0.5 * side + r * std::sin(angle));
    }
    way -= arc;
  }
  return {half.x(), -straight.y()};
}

// --- cloth

constexpr double kClothLeft = -0.275, kClothRight = 0.085;  // x. Unit: [m].
constexpr double kClothBack = 0.235;                        // y. Unit: [m].
constexpr double kClothFold = -0.305;                       // y, where it bends down. Unit: [m].
constexpr double kClothHang = 0.115;                        // Unit: [m].
constexpr double kClothThickness = 0.0015;                  // Unit: [m].
constexpr double kClothBend = 0.0115;                       // radius. Unit: [m].

/// Height of the cloth above its support, in its own coordinates: x, and the distance from its back edge.
double cloth_height(double x, double way) {
  const double y = kClothBack - way;
  const double off = (Vector2d(x, y) - bowl_place().head<2>()).norm();
  const double free = smooth(0.055, 0.15, off);
  const double past = std::max(0.0, kClothFold - y);              // the hanging part
  const double along = past > 0.0 ? kClothFold - 0.4 * past : y;  // folds hang down straight
  const Vector3d p(12.0 * x, 6.5 * along, 0.3);
  const Vector3d away(9.0, 0.0, 0.0);
  const Vector3d bent = p + 0.7 * Vector3d(solid_noise(0.6 * p, 60), solid_noise(0.6 * p + away, 61), 0.0);
  const double folds = 0.5 + 0.5 * fractal_noise(bent, 2, 62);
  const double crest = 0.5 + 0.5 * ridged_noise(0.9 * bent + away, 2, 63);
  const double creases = 0.5 + 0.5 * ridged_noise(2.6 * bent, 2, 67);
  const double bend = 1.0 - 0.7 * std::exp(-std::pow((y - kClothFold) / 0.02, 2.0));
  const double height = 0.020 * folds * folds + 0.026 * crest * crest * crest + 0.005 * creases * creases;
  // The border lies on the table, or nearly.
  const double inward = std::min({x - kClothLeft, kClothRight - x, way});
  return kClothThickness + free * bend * (0.2 + 0.8 * smooth(0.005, 0.06, inward)) * height;
}

Vector3d cloth_point(double u, double v) {
  const double length = kClothBack - kClothFold + 0.5 * pi * kClothBend + kClothHang;
  const double way = length * v;
  double x = kClothLeft + (kClothRight - kClothLeft) * u;
  x += 0.014 * solid_noise(Vector3d(3.0 * x, 4.0 * way, 7.0), 64);
  const double flat = kClothBack - kClothFold;
  const double height = cloth_height(x, way);
  const double back = 0.012 * solid_noise(Vector3d(6.0 * x, 0.0, 3.0), 65) * (1.0 - smooth(0.0, 0.2, way));
  if (way <= flat) return {x, kClothBack - way + back, height};
  const double bent = std::min(way - flat, 0.5 * pi * kClothBend);
  const double angle = bent / kClothBend;
  const double r = kClothBend + height;
  const double hangs = std::max(0.0, way - flat - 0.5 * pi * kClothBend);
  return {x, kClothFold - r * std::sin(angle), -kClothBend + r * std::cos(angle) - hangs};
}

Paint linen(double, double v, const Vector3d& p) {
  const double length = kClothBack - kClothFold + 0.5 * pi * kClothBend + kClothHang;
  const double from_hem = std::min(length * v, length * (1.0 - v));
  const double weave = solid_noise(420.0 * p, 66);
  Vector3d albedo = linear_color(0xcfc6b4) * (0.93 + 0.08 * weave);
  const auto stripe = [&](double middle, double half) {
    return 1.0 - smooth(half - 0.001, half + 0.001, std::abs(from_hem - middle));
  };
  const double blue = std::max({stripe(0.028, 0.003), stripe(0.044, 0.008), stripe(0.060, 0.003)});
  albedo = mixed(albedo, linear_color(0x2f567f) * (0.9 + 0.15 * weave), 0.92 * blue);
  return {albedo, 0.0};
}

/// Distance to the cloth; everything below it, down to the table, is occupied.
double cloth_distance(const Vector3d& p) {
  const double out_x = std::max(kClothLeft - p.x(), p.x() - kClothRight);
  const double out_y = std::max(kClothFold - p.y(), p.y() - kClothBack);
  const double out = std::max(out_x, out_y) + 0.026;  // its border is not straight
  const double above = 0.75 * (p.z() - cloth_height(p.x(), kClothBack - p.y()));
  return out > 0.0 ? std::hypot(out, std::max(0.0, above)) : above;
}

// --- bowl

constexpr double kBowlRim = 0.13;                       // radius. Unit: [m].
constexpr double kBowlFloor = 0.010, kBowlTop = 0.082;  // heights inside. Unit: [m].
constexpr double kBowlCurve = (kBowlTop - kBowlFloor) / (kBowlRim * kBowlRim);
constexpr double kBowlWall = 0.0055;  // Unit: [m].
constexpr double kFoot = 0.052;       // radius. Unit: [m].

/// Profile from the table up the outside, over the rim, down to the middle: radius and height over arc
/// length.
class BowlProfile {
 public:
  BowlProfile() {
    const auto inside = [](double r) { return Vector2d(r, kBowlFloor + kBowlCurve * r * r); };
    const auto outward = [](double r) { return Vector2d(2.0 * kBowlCurve * r, -1.0).normalized(); };
    add(Vector2d(kFoot - 0.004, 0.0));
    const Vector2d knee = inside(kFoot) + kBowlWall * outward(kFoot);
    add(Vector2d(kFoot, 0.0005));
    add(Vector2d(kFoot, 0.6 * knee.y()));
    constexpr int kPieces = 40;
    for (int k = 1; k <= kPieces; ++k) {
      const double r = kFoot + (kBowlRim - kFoot) * k / kPieces;
      add(inside(r) + kBowlWall * outward(r));
    }
    const Vector2d rim = inside(kBowlRim), n = outward(kBowlRim), t(-n.y(), n.x());
    constexpr int kRound = 10;
    for (int k = 1; k <= kRound; ++k) {
      const double angle = pi * k / kRound;
      add(rim + 0.5 * kBowlWall * n + 0.5 * kBowlWall * (std::cos(angle) * n + std::sin(angle) * t));
    }
    for (int k = kPieces - 1; k >= 0; --k) add(inside(kBowlRim * k / kPieces));
  }

  Vector2d at(double share) const {
    const double way = std::clamp(share, 0.0, 1.0) * ways_.back();
    const auto next = std::upper_bound(ways_.begin(), ways_.end(), way);
    const auto i = std::min<std::size_t>(static_cast<std::size_t>(next - ways_.begin()), ways_.size() - 1);
    const double step = ways_[i] - ways_[i - 1];
    return points_[i - 1] + (points_[i] - points_[i - 1]) * ((way - ways_[i - 1]) / step);
  }
  /// Position of the top of the rim, in [0, 1].
  double rim() const { return ways_[48] / ways_.back(); }

 private:
  void add(const Vector2d& p) {
    ways_.push_back(points_.empty() ? 0.0 : ways_.back() + (p - points_.back()).norm());
    points_.push_back(p);
  }
  std::vector<Vector2d> points_;
  std::vector<double> ways_;
};

double bowl_distance(const Vector3d& p) {
  const Vector3d q = p - bowl_place();
  const double r = std::hypot(q.x(), q.y());
  const double at = std::min(r, kBowlRim);
  const double slope = 2.0 * kBowlCurve * at;
  const double steep = std::sqrt(1.0 + slope * slope);
  const double middle = kBowlFloor + kBowlCurve * at * at - 0.5 * kBowlWall * steep;
  const double wall =
      r <= kBowlRim ? std::abs(q.z() - middle) / steep : std::hypot(r - kBowlRim, q.z() - middle);
  const double foot = cylinder_distance(q - Vector3d(0, 0, 0.006), kFoot, 0.006);
  return std::min(wall - 0.5 * kBowlWall, foot);
}

// --- log

constexpr double kLogRadius = 0.050, kLogHalf = 0.150;  // Unit: [m].
constexpr double kBark = 0.0055;                        // Unit: [m].

Pose log_pose() {
  const Vector3d axis(0.78, 0.6258, 0.0);
  Pose pose;
  pose.position = {0.24, 0.175, kLogRadius + 0.001};
  Eigen::Matrix3d R;  // z along the log, x up
  R << Vector3d::UnitZ(), axis.normalized().cross(Vector3d::UnitZ()), axis.normalized();
  pose.orientation = Eigen::Quaterniond(R).normalized();
  return pose;
}

/// Depth of the bark at a point of the cylinder, in [0, 1]: long plates with furrows between them.
double bark_furrow(const Vector3d& local) {
  const Vector3d p(62.0 * local.x(), 62.0 * local.y(), 17.0 * local.z());
  const Vector3d bent =
      p + 0.5 * Vector3d(solid_noise(0.7 * p, 70), solid_noise(0.7 * p, 71), 1.4 * solid_noise(0.9 * p, 72));
  return smooth(0.35, 0.95, 0.5 + 0.5 * ridged_noise(bent, 2, 73));
}

Paint bark(const Vector3d& local, const Vector3d& p) {
  const double furrow = bark_furrow(local);
  const double fine = fractal_noise(160.0 * local, 3, 74);
  Vector3d albedo = mixed(linear_color(0x8a7460), linear_color(0x2e2119), 0.95 * furrow) * (1.0 + 0.3 * fine);
  const double moss =
      smooth(0.1, 0.6, fractal_noise(24.0 * local, 3, 75) + 0.8 * (p.z() - 0.085) / 0.02 - 0.3);
  return {mixed(albedo, linear_color(0x5f7430) * (1.0 + 0.4 * fine), 0.7 * moss * (1.0 - 0.6 * furrow)), 0.0};
}

Paint log_end(const Vector3d& local) {
  const Vector3d off(0.004, -0.003, 0.0);
  const double r = std::hypot(local.x() - off.x(), local.y() - off.y());
  const double wobble = 0.0022 * solid_noise(Vector3d(45.0 * local.x(), 45.0 * local.y(), 1.0), 76);
  const double ring = 0.5 + 0.5 * std::sin(2.0 * pi * (r + wobble) / 0.0052);
  const double around = std::atan2(local.y(), local.x());
  const double ray = groove(std::remainder(around - 0.8, 2.0 * pi) * r, 0.0016) * smooth(0.002, 0.02, r);
  Vector3d albedo = mixed(linear_color(0xc89f6a), linear_color(0x9b6c3c), 0.75 * ring);
  albedo = mixed(albedo, linear_color(0x5a3a22), std::max(0.8 * ray, smooth(0.043, 0.047, r)));
  return {albedo, 0.0};
}

// --- plate

constexpr double kPlateRadius = 0.080, kPlateHalf = 0.003;  // Unit: [m].
constexpr double kEngraved = 0.0013;                        // Unit: [m].

Pose plate_pose() {
  // Its lower edge stands on the table, its back leans on the log.
  constexpr double kTilt = pi / 3.0;
  const Pose wood = log_pose();
  const Vector3d axis = wood.orientation * Vector3d::UnitZ();
  const Vector3d front = axis.cross(Vector3d::UnitZ());
  const double r = kLogRadius + kBark;
  const double before = (r + r * std::cos(kTilt)) / std::sin(kTilt) + 0.002;
  const Vector3d along = -std::cos(kTilt) * front + std::sin(kTilt) * Vector3d::UnitZ();
  const Vector3d normal = std::sin(kTilt) * front + std::cos(kTilt) * Vector3d::UnitZ();
  Vector3d foot = wood.position + 0.088 * axis + before * front;
  foot.z() = 0.0;
  Eigen::Matrix3d R;
  R << axis, normal.cross(axis), normal;
  return {foot + kPlateRadius * along + kPlateHalf * normal, Eigen::Quaterniond(R).normalized()};
}

/// Depth of the engraving, in [0, 1]: rings, a milled band, and a rose of twelve leaves.
double engraving(double r, double around) {
  double deep = std::max(groove(r - 0.0735, 0.0022), groove(r - 0.0575, 0.0022));
  if (r > 0.0595 && r < 0.0715)
    deep = std::max(deep, (0.5 - 0.5 * std::cos(54.0 * around)) * smooth(0.0595, 0.0615, r) *
                              (1.0 - smooth(0.0695, 0.0715, r)));
  const double leaf = 0.034 + 0.017 * std::cos(6.0 * around);
  const double slope = std::hypot(1.0, 0.017 * 6.0 * std::sin(6.0 * around) / std::max(r, 0.01));
  deep = std::max(deep, groove((r - leaf) / slope, 0.0020));
  const double between = 0.034 - 0.017 * std::cos(6.0 * around);
  deep = std::max(deep, groove((r - between) / slope, 0.0020));
  return std::max(deep, groove(r - 0.010, 0.0020));
}

Paint brass(double r, double around) {
  const double deep = engraving(r, around);
  const double turned = solid_noise(Vector3d(900.0 * r, 1.5 * std::cos(around), 1.5 * std::sin(around)), 80);
  const double patina =
      smooth(0.0, 0.8,
             fractal_noise(Vector3d(30.0 * r * std::cos(around), 30.0 * r * std::sin(around), 2.0), 3, 81));
  Vector3d albedo = linear_color(0xe0b45c) * (1.0 + 0.12 * turned);
  albedo = mixed(albedo, linear_color(0x9c7a44), 0.4 * patina);
  return {mixed(albedo, linear_color(0x2f2413), 0.88 * deep), 0.85 * (1.0 - deep)};
}

}  // namespace

const Vector3d& bowl_place() {
  static const Vector3d place(-0.085, 0.075, kClothThickness);
  return place;
}

double rest_height(const SoftLight& taken, double x, double y, double radius) {
  constexpr double kAbove = 0.45, kNear = 0.0004;  // Unit: [m].
  double z = kAbove;
  for (int k = 0; k < 200; ++k) {
    const double room = taken.distance({x, y, z}, kAbove) - radius;
    if (room < kNear) break;
    z -= room;
  }
  return z;
}

Thing make_table(double spacing) {
  Thing thing{"table", {1200.0, 0.35, std::nullopt}, {}, {}};
  const Vector3d half(kTableHalfX, kTableHalfY, 0.5 * kThickness);
  const Vector3d middle(0.0, 0.0, -0.5 * kThickness);
  const double inset = kEdge;
  thing.patches.push_back(
      {[=](double u, double v) -> Vector3d {
         const Vector3d p((2.0 * u - 1.0) * (half.x() - inset), (2.0 * v - 1.0) * (half.y() - inset), 0.0);
         return p + Vector3d(0, 0, kGrain * wood_grain(p) - kGrain - kJoint * wood_joint(p.y()));
       },
       wood, spacing, [=](const Vector3d& p) { return is_on_table(p, inset); }});
  thing.patches.push_back({[=](double u, double v) -> Vector3d {  // side: u around, v up
                             const double way = (1.0 - v) * (pi * kEdge + kThickness - 2.0 * kEdge);
                             const double top = 0.5 * pi * kEdge, side = kThickness - 2.0 * kEdge;
                             double in = 0.0, z = 0.0;
                             if (way < top) {
                               in = kEdge * (1.0 - std::sin(way / kEdge));
                               z = -kEdge * (1.0 - std::cos(way / kEdge));
                             } else if (way < top + side) {
                               z = -kEdge - (way - top);
                             } else {
                               const double angle = (way - top - side) / kEdge;
                               in = kEdge * (1.0 - std::cos(angle));
                               z = -kThickness + kEdge * (1.0 - std::sin(angle));
                             }
                             const Vector2d p = outline(u, in);
                             return {p.x(), p.y(), z - kGrain};
                           },
                           wood, 1.1 * spacing});
  thing.patches.push_back(
      {[=](double u, double v) -> Vector3d {
         return {(1.0 - 2.0 * u) * (half.x() - inset), (2.0 * v - 1.0) * (half.y() - inset), -kThickness};
       },
       wood, 2.5 * spacing, [=](const Vector3d& p) { return is_on_table(p, 2.0 * inset); }});
  thing.room.push_back(
      {middle, half.norm(), [=](const Vector3d& p) { return box_distance(p - middle, half); }, 0});
  thing.shape = make_box(2.0 * half);
  thing.pose.position = middle;
  thing.relief = (std::numbers::sqrt2 - 1.0) * kCorner + kEdge;  // due to its corners
  return thing;
}

Thing make_cloth(double spacing) {
  Thing thing{"cloth", {350.0, 0.85, 1.0}, {}, {}};
  // v increases from back to front, so u must increase from right to left.
  thing.patches.push_back(
      {[](double u, double v) { return cloth_point(1.0 - u, v); }, linen, 0.76 * spacing});
  const Vector3d middle(0.5 * (kClothLeft + kClothRight), 0.5 * (kClothBack + kClothFold), 0.0);
  thing.room.push_back({middle, 0.34, cloth_distance, 0});
  return thing;
}

Thing make_bowl(double spacing) {
  Thing thing{"bowl", {1800.0, 0.12, std::nullopt}, {}, {}};
  const auto profile = std::make_shared<const BowlProfile>();
  const double rim = profile->rim();
  const auto turned = [=](double v) {
    return v < rim - 0.03 ? 0.00035 * std::sin(2.0 * pi * v * 46.0) : 0.0;
  };
  thing.patches.push_back(
      {[=](double u, double v) -> Vector3d {
         const Vector2d p = profile->at(v);
         const double r = p.x() + turned(v);
         const double angle = 2.0 * pi * u;
         return bowl_place() + Vector3d(r * std::cos(angle), r * std::sin(angle), p.y());
       },
       [=](double, double v, const Vector3d& p) {
         const Vector3d q = p - bowl_place();
         const bool outside = v < rim;
         const double drift = fractal_noise(18.0 * q, 3, 90);
         Vector3d albedo = outside ? mixed(linear_color(0x2f6f78), linear_color(0x3d8a8c), 0.5 + 0.6 * drift)
                                   : mixed(linear_color(0x9fc0b4), linear_color(0xc3d6c6), 0.5 + 0.6 * drift);
         if (solid_noise(330.0 * q, 91) > 0.62) albedo *= 0.72;
         const double worn = std::max(1.0 - smooth(0.0, 0.012, std::abs(v - rim)),
                                      outside ? 1.0 - smooth(0.010, 0.014, q.z()) : 0.0);
         return Paint{mixed(albedo, linear_color(0x9a7350), worn), 0.8 * (1.0 - worn)};
       },
       0.8 * spacing});
  thing.room.push_back({bowl_place() + Vector3d(0, 0, 0.04), 0.142, bowl_distance, 0});
  return thing;
}

Thing make_log(double spacing) {
  const Pose pose = log_pose();
  Thing thing{"log", {1500.0, 0.9, std::nullopt}, {}, {}};
  const auto world = [pose](const Vector3d& local) -> Vector3d {
    return pose.orientation * local + pose.position;
  };
  const auto radius_at = [](const Vector3d& on) {
    return kLogRadius + kBark * (0.35 - 0.85 * bark_furrow(on)) + 0.0012 * solid_noise(40.0 * on, 77);
  };
  const auto on_side = [](double u, double v) {
    const double angle = 2.0 * pi * u;
    return Vector3d(kLogRadius * std::cos(angle), kLogRadius * std::sin(angle), kLogHalf * (2.0 * v - 1.0));
  };
  thing.patches.push_back({[=](double u, double v) -> Vector3d {
                             const Vector3d on = on_side(u, v);
                             const double share = radius_at(on) / kLogRadius;
                             return world({share * on.x(), share * on.y(), on.z()});
                           },
                           [=](double u, double v, const Vector3d& p) { return bark(on_side(u, v), p); },
                           0.72 * spacing});
  for (const double end : {-1.0, 1.0}) {
    thing.patches.push_back(
        {[=](double u, double v) -> Vector3d {
           const double angle = -end * 2.0 * pi * u;
           const Vector3d on(kLogRadius * std::cos(angle), kLogRadius * std::sin(angle), end * kLogHalf);
           const double r = v * radius_at(on);
           const double ring = 0.0004 * std::sin(2.0 * pi * r / 0.0052) * smooth(0.0, 0.004, r) - 0.0004;
           return world({r * std::cos(angle), r * std::sin(angle), end * (kLogHalf + ring)});
         },
         [pose](double, double, const Vector3d& p) { return log_end(to_local(pose, p)); }, 0.72 * spacing});
  }
  thing.room.push_back(
      {pose.position, std::hypot(kLogRadius, kLogHalf) + 0.002,
       [pose](const Vector3d& p) { return cylinder_distance(to_local(pose, p), kLogRadius, kLogHalf); }, 0});
  thing.shape = make_cylinder(kLogRadius, 2.0 * kLogHalf);
  thing.pose = pose;
  thing.relief = kBark;
  return thing;
}

Thing make_plate(double spacing) {
  const Pose pose = plate_pose();
  Thing thing{"plate", {2000.0, 0.1, std::nullopt}, {}, {}};
  const auto world = [pose](double r, double angle, double z) -> Vector3d {
    return pose.orientation * Vector3d(r * std::cos(angle), r * std::sin(angle), z) + pose.position;
  };
  // v increases outward, so u must increase clockwise for the face to point along +z.
  thing.patches.push_back(
      {[=](double u, double v) {
         return world(kPlateRadius * v, -2.0 * pi * u,
                      kPlateHalf - kEngraved * engraving(kPlateRadius * v, -2.0 * pi * u));
       },
       [](double u, double v, const Vector3d&) { return brass(kPlateRadius * v, -2.0 * pi * u); },
       0.42 * spacing});
  thing.patches.push_back(
      {[=](double u, double v) { return world(kPlateRadius, 2.0 * pi * u, kPlateHalf * (2.0 * v - 1.0)); },
       [](double, double, const Vector3d&) {
         return Paint{linear_color(0xb08a44), 0.6};
       },
       0.6 * spacing});
  thing.patches.push_back(
      {[=](double u, double v) { return world(kPlateRadius * v, 2.0 * pi * u, -kPlateHalf); },
       [](double, double, const Vector3d&) {
         return Paint{linear_color(0x8a6a3a), 0.3};
       },
       spacing});
  thing.room.push_back(
      {pose.position, kPlateRadius + kPlateHalf,
       [pose](const Vector3d& p) { return cylinder_distance(to_local(pose, p), kPlateRadius, kPlateHalf); },
       0});
  thing.shape = make_cylinder(kPlateRadius, 2.0 * kPlateHalf);
  thing.pose = pose;
  thing.relief = kEngraved + 1e-4;
  return thing;
}

Thing make_stone(double spacing, const Vector3d& center, const Vector3d& semi_axes, double turn, double tilt,
                 unsigned rgb, std::uint32_t seed) {
  const Pose pose{center,
                  Eigen::AngleAxisd(turn, Vector3d::UnitZ()) * Eigen::AngleAxisd(tilt, Vector3d::UnitX())};
  Thing thing{"stone", {2000.0, 0.55, std::nullopt}, {}, {}};
  const auto direction = [](double u, double v) {
    const double polar = pi * (1.0 - v), around = 2.0 * pi * u;
    return Vector3d(std::sin(polar) * std::cos(around), std::sin(polar) * std::sin(around), std::cos(polar));
  };
  const auto bumps = [seed](const Vector3d& d) { return 1.0 + 0.06 * fractal_noise(1.6 * d, 2, seed); };
  const auto grit = [seed](const Vector3d& d) { return fractal_noise(28.0 * d, 2, seed + 3U); };
  thing.patches.push_back({[=](double u, double v) -> Vector3d {
                             const Vector3d d = direction(u, v);
                             const Vector3d local =
                                 bumps(d) * semi_axes.cwiseProduct(d) + 0.00015 * grit(d) * d;
                             return pose.orientation * local + pose.position;
                           },
                           [=](double u, double v, const Vector3d&) {
                             const Vector3d d = direction(u, v);
                             const Vector3d base = linear_color(rgb);
                             Vector3d albedo =
                                 base * (0.9 + 0.3 * fractal_noise(3.0 * d, 3, seed + 5U) + 0.22 * grit(d));
                             const double vein = groove(fractal_noise(1.4 * d, 2, seed + 7U) - 0.12, 0.035);
                             albedo = mixed(albedo, linear_color(0xd8d2c4),
                                            0.6 * vein * smooth(-0.2, 0.4, solid_noise(2.0 * d, seed + 8U)));
                             return Paint{albedo, 0.08};
                           },
                           0.72 * spacing});
  thing.room.push_back({center, 1.05 * semi_axes.maxCoeff(),
                        [=](const Vector3d& p) {
                          const Vector3d q = to_local(pose, p);  // distance to an ellipsoid, to first order
                          const double k0 = q.cwiseQuotient(semi_axes).norm();
                          const double k1 = q.cwiseQuotient(semi_axes.cwiseProduct(semi_axes)).norm();
                          return k1 > 0.0 ? k0 * (k0 - 1.0) / k1 : -semi_axes.minCoeff();
                        },
                        0});
  return thing;
}

}  // namespace palpate::still_life

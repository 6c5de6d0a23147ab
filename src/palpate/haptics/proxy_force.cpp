#include <palpate/haptics/proxy_force.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include <palpate/collision/pair_buffer.h>
#include <palpate/geometry/rotation.h>
#include <palpate/geometry/solids.h>

namespace palpate {
namespace {

/// Length of a step, as a fraction of the longest, below which the next tick continues: over so short a
/// distance, the surface deviates from its patches by no more than a hundredth of it.
constexpr double kSettled = 0.1;

/// Motion from one pose to another.
Motion motion_between(const Pose& from, const Pose& to) {
  return {to.position - from.position, turn_between(from.orientation, to.orientation)};
}

/// Pose at the end of a motion.
Pose after(const Pose& from, const Motion& motion) {
  return {from.position + motion.translation, (rotation_by(motion.rotation) * from.orientation).normalized()};
}

/// Input in the anchor frame of a scene, from that in the world.
ForceInput in_anchor(const Pose& X_WA, ForceInput input) {
  const Eigen::Quaterniond back = X_WA.orientation.conjugate();
  input.tool = {back * (input.tool.position - X_WA.position), back * input.tool.orientation};
  input.velocity = {back * input.velocity.linear, back * input.velocity.angular};
  return input;
}

/// Output in the world, from that in the anchor frame of a scene.
ForceOutput in_world(const Pose& X_WA, ForceOutput output) {
  const Eigen::Quaterniond& to_world = X_WA.orientation;
  output.wrench = {to_world * output.wrench.force, to_world * output.wrench.torque};
  output.proxy = X_WA * output.proxy;
  for (ContactPlane& plane : output.local.planes)
    plane = {to_world * plane.point + X_WA.position, to_world * plane.normal};
  return output;
}

Motion blend(const Motion& a, const Motion& b, double of_b) {
  return {a.translation + of_b * (b.translation - a.translation),
          a.rotation + of_b * (b.rotation - a.rotation)};
}

/// Largest speed of the proxy in excess of the tool's. The constraints may change at once where a fit finds
/// another patch; the force then changes by 0.05 N a millisecond at 500 N/m, which a hand does not perceive
/// as an edge, and the proxy does not overshoot where the surface is more curved than it looks. Unit: [m/s].
constexpr double kCatchUp = 0.1;

/// Limit of the force change by a change of stiffness, as an equivalent speed of the proxy. Unit: [m/s].
constexpr double kSoften = 0.03;

/// Least fraction of kCatchUp, for a proxy without any direction.
constexpr double kLeastPurpose = 0.01;

/// Motion in a tick beyond which the tool restarts: no hand moves so far. Unit: [m].
constexpr double kJump = 1.0;

/// Lower bound of a stiffness that is divided by. Unit: [N/m].
constexpr double kLeastStiffness = 1.0;

/// Distance over which the heading of a part is averaged, as a fraction of its shortest semi-axis.
constexpr double kHeadingOfTool = 0.25;
/// Least length of the heading for it to replace the direction to the target, and least cosine between both.
constexpr double kStraight = 0.3, kSameWay = 0.5;
/// Excess of a view over the motion, as a fraction of the detail, and least cosine between the two directions
/// for a view to be reused.
constexpr double kAhead = 0.01, kSameDirection = 0.95;

/// Least cosine between the motion of a part and the inward normal at which it meets a surface head-on.
/// Surfaces lower down are under it, where it has looked already: bumps of what it slides on are no walls.
constexpr double kHeadOn = 0.98;

/// How often a step is computed anew for surfaces found along it: a floor, a wall, and a corner of both.
constexpr int kMostTurns = 3;

/// Largest ratio of the longest to the shortest semi-axis at which a rotation of the part sweeps over
/// nothing, and least motion of its ends, in details, that needs a view.
constexpr double kRound = 1.05, kLeastSweep = 1e-3;

/// Displacement of a part that searches for the objects it starts in, as a fraction of its thinnest
/// semi-axis: in the very plane of a flat Gaussian the normals of contacts lie in that plane, and on neither
/// side.
const Eigen::Vector3d kToOneSide = 1e-2 * Eigen::Vector3d(0.27, 0.53, 0.80);

/// Fraction of a patch's window that is viewed.
constexpr double kShown = 0.88;

/// Time constant of the velocity filter for damping: a tenth of the shortest time in which a hand reverses.
/// Unit: [s].
constexpr double kVelocityFilter = 0.005;

}  // namespace

double detail_of(const ToolPart& part, const ProxyParameters& parameters) {
  return parameters.detail.value_or(ProxyParameters::kDetailOfTool * part.semi_axes.minCoeff());
}

/// With (a + reach)^2 = a^2 + w^2, the plane under a ball of radius a is in view out to w, where the kernel
/// has a hundredth of its weight. A ray also meets Gaussians whose ellipsoids end before it.
double reach_of(const ToolPart& part, double detail, double extent) {
  const double a_min = part.semi_axes.minCoeff();
  return std::max(std::hypot(a_min, kShown * SurfacePatches::kWindow * detail) - a_min, 0.5 * extent);
}

/// Semi-axes are sqrt(p a_i^2 + q), of least volume among those that contain a disc of radius w touching the
/// part at an end of its longest axis and of its shortest. With a and b the squares of both, that is
///
///     a / (p a + q) + w^2 / (p b + q) = 1,    p b + q >= b + w^2,    1 < p <= 1 + w^2 / b
ToolPart enlarged(const ToolPart& part, double detail, double reach) {
  constexpr int kTries = 32;
  const Eigen::Array3d squared = part.semi_axes.array().square();
  const double a = squared.maxCoeff(), b = squared.minCoeff();
  const double w2 = std::pow(kShown * SurfacePatches::kWindow * detail, 2);
  Eigen::Array3d best = squared * (1.0 + w2 / b);
  for (int k = 1; k < kTries; ++k) {
    const double p = 1.0 + k * w2 / (kTries * b);
    const double half = 0.5 * (a + w2 - p * (a + b)), rest = p * a * (b + w2 - p * b);
    const double q = std::max(half + std::sqrt(std::max(0.0, half * half + rest)), b + w2 - p * b);
    const Eigen::Array3d tried = p * squared + q;
    if (tried.prod() < best.prod()) best = tried;
  }
  ToolPart larger = part;
  larger.semi_axes = best.sqrt().max(part.semi_axes.array() + reach);
  return larger;
}

std::size_t enough_for(const ToolPart& part, double detail) {
  constexpr double kPerDetail = 64.0;
  const double wanted = kPerDetail * std::numbers::pi * section(part) / (detail * detail);
  return std::clamp(static_cast<std::size_t>(std::min(wanted, 1e9)), CandidateCache::kLeastCapacity,
                    CandidateCache::kCapacity);
}

ProxyForce::ProxyForce(const SceneIndex& index, const Tool& tool, const ProxyParameters& parameters,
                       Lookahead* lookahead)
    : scene_(index),
      parameters_(parameters),
      gyration_(std::min(kTurning * tool.gyration(), parameters.arm_max)),
      radius_(tool.radius()),
      step_(std::numeric_limits<double>::infinity()) {
  const double extent = index.usual_extent();
  const std::size_t capacity = CandidateCache::capacity_for(tool.parts().size());
  std::vector<ToolPart> larger;
  for (const ToolPart& part : tool.parts()) {
    parts_.emplace_back(scene_.scene(), part, parameters, extent, lookahead, capacity, budget_);
    step_ = std::min(step_, 0.5 * parts_.back().reach);
    larger.push_back(parts_.back().larger);
  }
  const std::vector<PartGroup> groups = group_parts(larger);
  const std::size_t splat_capacity = CandidateCache::capacity_for(groups.size());
  for (const PartGroup& group : groups) {
    const bool single = group.members.size() == 1;
    const std::size_t enough =
        single ? enough_for(group.around, parts_[group.members[0]].patches.detail()) : splat_capacity;
    groups_.emplace_back(scene_.scene(), group.around, single, lookahead, std::min(enough, splat_capacity));
    for (const std::size_t k : group.members) parts_[k].join(groups_.back(), capacity);
  }
  contacts_.contacts.reserve(kMostPairs + 2 * PairBuffer::kCapacity);
  obstacles_.planes.reserve(SurfacePatches::kMost * parts_.size());
  obstacles_.properties.reserve(SurfacePatches::kMost * parts_.size());
}

void ProxyForce::reset() {
  started_ = held_ = trails_ = replaced_ = false;
  hold_ = {};
  spring_ = {};
  spring_.reserve = most_reserve();
  owed_ = 0.0;
  pull_.reset();
  velocity_.setZero();
  direction_.setZero();
  forget_surface();
  for (Part& part : parts_) part.heading.setZero();
}

void ProxyForce::forget_surface() {
  waits_ = false;
  obstacles_.planes.clear();
  obstacles_.properties.clear();
  for (Part& part : parts_) {
    part.patches.clear();
    part.ahead = part.aside = part.one_end = part.other_end = {};
    part.ready = false;
  }
}

void ProxyForce::start_at_proxy() {
  first_ = (first_ + starting_) % parts_.size();
  starting_ = 0;
  start_ = proxy_;
  knows_start_ = false;
  steps_out_ = kMostFreeSteps;
}

bool ProxyForce::touches(Part& part, const Ellipsoid& solid) {
  find_contacts(part, solid, {.contacts = 1});
  return !contacts_.contacts.empty();
}

void ProxyForce::find_contacts(Part& part, const Ellipsoid& solid, QueryLimit limit) {
  part.touched.query(solid, contacts_, limit);
  budget_.spend_on_touch(part.touched.searched() + contacts_.contacts.size());
}

void ProxyForce::find_deepest(Part& part, const Ellipsoid& solid) {
  constexpr QueryLimit kLimit{.pairs = kMostPairs};
  constexpr double kLess = 0.7;
  constexpr int kMostTimes = 12;  // down to a hundredth: the contacts are then in one place
  Ellipsoid deep = solid;
  find_contacts(part, deep, kLimit);
  for (int k = 0; k < kMostTimes && !contacts_.complete; ++k) {
    const Ellipsoid deeper{deep.center, kLess * deep.axes};
    const bool any = touches(part, deeper);
    if (any) deep = deeper;
    find_contacts(part, deep, kLimit);
    if (!any) break;
  }
  std::ranges::make_heap(contacts_.contacts, {}, &Contact::depth);
}

bool ProxyForce::start() {
  for (; starting_ < parts_.size(); ++starting_) {
    const bool at_once = replaced_ && starting_ < kFewParts;
    if (!at_once && budget_.is_half_spent()) return false;
    if (!start_patches(parts_[(first_ + starting_) % parts_.size()], at_once)) return false;
  }
  return true;
}

void ProxyForce::leave_known() {
  for (Part& part : parts_) part.meets = true;
  // Patches whose material there was no time to find hold, too.
  find_obstacles();
  budget_.spend_on_motion(obstacles_.planes.size());
  const Motion motion = constrained_motion({}, obstacles_.planes, gyration_);
  const Hold held = hold();
  if (held.push == 0.0) return;
  held_ = trails_ = true;
  hold_ = held;
  proxy_ = after(proxy_, motion);
  for (Part& part : parts_) part.patches.carry(part.solid.at(proxy_));
}

bool ProxyForce::start_patches(Part& part, bool at_once) {
  const Ellipsoid solid = part.solid.at(proxy_);
  if (!knows_start_) {
    if (!touches(part, solid)) return true;
    if (!search(*part.group, at_once ? kAllPairs : budget_.search_limit())) return false;
    if (!at_once && budget_.is_half_spent()) return false;
    const double thinnest = part.solid.semi_axes.minCoeff();
    find_deepest(part, {solid.center + thinnest * kToOneSide, solid.axes});
    if (at_once) budget_.refill();  // in addition to the work of a tick
    knows_start_ = true;
  }
  for (; !contacts_.contacts.empty(); contacts_.contacts.pop_back()) {
    if (budget_.is_half_spent()) {
      if (replaced_) break;  // skips the others, to leave the object in this tick
      return false;
    }
    std::ranges::pop_heap(contacts_.contacts, {}, &Contact::depth);
    const Contact& deepest = contacts_.contacts.back();
    part.patches.add_at(part.group->splats.newest(), solid, deepest.normal, deepest.point);
    budget_.spend_on_start();
  }
  knows_start_ = false;
  return true;
}

bool ProxyForce::view_along(Part& part, Sight& sight, const LocalSplats& splats, const ViewRequest& request,
                            const Pose& target) {
  const Ellipsoid solid = part.solid.at(proxy_);
  if (sight.done) return true;
  const double moved = way_between(sight.from, solid);
  const double detail = part.patches.detail(), seen = request.way + kAhead * detail;
  if (moved + seen <= sight.clear && request.along.dot(sight.along) > kSameDirection) return true;
  // A surface that the part does not touch at the end of its motion adds no patch, however far the view
  // extends.
  const Ellipsoid next{solid.center + request.way * request.along, solid.axes}, there = part.solid.at(target);
  const auto admit = [&] {
    const bool met = touches(part, there) || (!request.arrives && touches(part, next));
    part.meets = part.meets || met;
    return met;
  };
  const std::optional<double> clear =
      part.patches.view_ahead(splats, solid, request.along, request.about, seen, request.head_on, admit);
  if (!clear) return false;
  sight = {solid, request.along, std::min({*clear, 0.5 * part.reach, 0.5 * detail}), true};
  return true;
}

bool ProxyForce::view_ahead(Part& part, const LocalSplats& splats, const Goal& goal) {
  if (splats.size == 0) return true;
  const auto& [target, longest] = goal;
  const Ellipsoid solid = part.solid.at(proxy_);
  const Eigen::Vector3d wanted = part.solid.at(target).center - solid.center;
  // The ends of a tool whose arm is shortened move farther than its length_of() says.
  const double farthest = std::min(step_, longest * std::max(1.0, radius_ / gyration_));
  const double length = wanted.norm();
  bool sees = true;
  if (length > 0.0) {
    Eigen::Vector3d along = wanted / length;
    const double heading = part.heading.norm();
    if (heading > kStraight && part.heading.dot(along) > kSameWay * heading) along = part.heading / heading;
    const ViewRequest request{along, farthest_point(solid, along), std::min(length, farthest),
                              length <= farthest};
    sees = view_along(part, part.ahead, splats, request, target);
  }
  // Where the part rotates, its ends move in opposite directions.
  Eigen::Index longest_axis = 0;
  const double radius = part.solid.semi_axes.maxCoeff(&longest_axis);
  if (radius <= kRound * part.solid.semi_axes.minCoeff()) return sees;
  const Eigen::Vector3d sweep =
      turn_between(proxy_.orientation, target.orientation).cross(solid.axes.col(longest_axis));
  const double swept = sweep.norm();
  if (swept < kLeastSweep * part.patches.detail()) return sees;
  for (const double end : {1.0, -1.0}) {
    Sight& sight = end > 0.0 ? part.one_end : part.other_end;
    const Eigen::Vector3d tip = solid.center + end * solid.axes.col(longest_axis);
    const ViewRequest request{end / swept * sweep, tip, std::min(swept, farthest), swept <= farthest};
    sees = view_along(part, sight, splats, request, target) && sees;
  }
  return sees;
}

bool ProxyForce::view_aside(Part& part, const Motion& motion, const Goal& goal) {
  const LocalSplats& splats = *part.near;
  if (splats.size == 0) return true;
  const Ellipsoid solid = part.solid.at(proxy_);
  const Eigen::Vector3d goes = motion.translation + motion.rotation.cross(solid.center - proxy_.position);
  const double length = goes.norm();
  if (length < kLeastSweep * part.patches.detail()) return true;
  const Eigen::Vector3d along = goes / length;
  if (along.dot(part.ahead.along) > kSameDirection) return true;
  const double way = std::min({length, step_, goal.longest});
  const ViewRequest request{along, farthest_point(solid, along), way, false, kHeadOn};
  return view_along(part, part.aside, splats, request, goal.target);
}

bool ProxyForce::may_meet(Part& part, const Goal& goal) {
  if (trails_ || part.patches.patches().empty()) return true;
  const Ellipsoid solid = part.solid.at(proxy_), there = part.solid.at(goal.target);
  return way_between(solid, there) > std::min(step_, goal.longest) || touches(part, there);
}

void ProxyForce::select_near(Part& part) {
  const LocalSplats& splats = part.group->splats.newest();
  part.near = &splats;
  if (part.group->is_single || splats.size == 0) return;
  if (select_splats(splats, part.larger.at(proxy_), *part.own)) part.near = part.own.get();
  budget_.spend_on_selection(splats.size, part.own->size);
}

bool ProxyForce::view_around(const Goal& goal) {
  for (Part& part : parts_) {
    if (!part.ready) part.ready = view_from(part, goal);
    if (!part.ready) return false;
  }
  return true;
}

bool ProxyForce::view_from(Part& part, const Goal& goal) {
  if (budget_.is_spent()) return false;
  budget_.spend_on_part();
  if (!search(*part.group, budget_.search_limit()) || budget_.is_spent()) return false;
  select_near(part);
  part.patches.follow(*part.near, part.solid.at(proxy_));
  part.meets = may_meet(part, goal);
  return view_ahead(part, *part.near, goal);
}

bool ProxyForce::search(Group& group, std::size_t most) {
  const bool found = group.splats.update(group.solid.at(proxy_), most);
  budget_.spend_on_taking_up(group.splats.taken_up());
  if (group.splats.has_searched()) budget_.spend_on_search(group.splats.walked(), group.splats.passed());
  return found;
}

bool ProxyForce::find_obstacles() {
  obstacles_.planes.clear();
  obstacles_.properties.clear();
  bool knows_all = true;
  for (Part& part : parts_) {
    if (!part.meets) continue;
    const std::span<const SurfacePatch> patches = part.patches.patches();
    for (std::size_t i = 0; i < patches.size(); ++i) {
      knows_all = find_material(part.patches, i) && knows_all;
      const Properties properties = properties_of(patches[i]);
      obstacles_.planes.push_back(
          {patches[i].normal, patches[i].foot - proxy_.position, patches[i].gap, properties.friction});
      obstacles_.properties.push_back(properties);
    }
  }
  return knows_all;
}

bool ProxyForce::find_material(SurfacePatches& patches, std::size_t i) {
  const std::span<const PatchWitness> witnesses = patches.witnesses(i);
  if (!parameters_.materials || parameters_.materials->empty() || witnesses.empty()) return true;
  if (patches.patches()[i].material) return true;
  if (budget_.is_spent()) return false;
  PatchMaterial sum{0.0, 0.0, 0.0};
  for (const PatchWitness& witness : witnesses) {
    const Material material = parameters_.materials->of(witness.id, witness.position);
    sum.stiffness += witness.weight * material.stiffness.value_or(parameters_.stiffness);
    sum.friction += witness.weight * material.friction.value_or(parameters_.friction);
    sum.damping += witness.weight * material.damping.value_or(0.0);
  }
  budget_.spend_on_materials(witnesses.size(), parameters_.materials->size());
  patches.set_material(i, sum);
  return true;
}

ProxyForce::Properties ProxyForce::properties_of(const SurfacePatch& patch) const {
  const PatchMaterial material =
      patch.material.value_or(PatchMaterial{parameters_.stiffness, parameters_.friction, 0.0});
  return {material.stiffness, material.friction, material.damping, patch.confidence};
}

ProxyForce::Hold ProxyForce::hold() const {
  Hold sum;
  sum.confidence = 0.0;
  for (std::size_t i = 0; i < obstacles_.planes.size(); ++i) {
    const double push = obstacles_.planes[i].push;
    const Properties& of = obstacles_.properties[i];
    sum.push += push;
    sum.confidence += push * of.confidence;
    sum.stiffness += push * of.stiffness;
    sum.damping += push * of.damping;
  }
  if (sum.push == 0.0) return {};
  return {sum.push, sum.confidence / sum.push, sum.stiffness / sum.push, sum.damping / sum.push};
}

namespace {

/// Inner product of motions; its norm is length_of().
double product(const Motion& a, const Motion& b, double gyration) {
  return a.translation.dot(b.translation) + gyration * gyration * a.rotation.dot(b.rotation);
}

/// The largest s in [0, 1] with |wanted - s motion| <= stretch; 0 if there is none.
double share_within(const Motion& wanted, const Motion& motion, double stretch, double gyration) {
  const double a = product(motion, motion, gyration), b = product(wanted, motion, gyration);
  const double c = product(wanted, wanted, gyration) - stretch * stretch;
  const double root = b * b - a * c;
  if (a == 0.0) return 1.0;
  return root < 0.0 ? 0.0 : std::clamp((b + std::sqrt(root)) / a, 0.0, 1.0);
}

}  // namespace

/// Returns the constrained motion that moves out of none of the planes.
Motion ProxyForce::motion_along_planes(const Motion& wanted) {
  for (MotionConstraint& plane : obstacles_.planes) plane.gap = std::max(0.0, plane.gap);
  return constrained_motion(wanted, obstacles_.planes, gyration_);
}

/// Blends towards `motion` as far as the spring allows, from the motion that moves out of none of the planes:
/// that one is the nearest to the wanted one of all that go no deeper, and never lengthens the spring.
Motion ProxyForce::less_wound(const Motion& wanted, const Motion& motion, double stretch) {
  const Motion along = motion_along_planes(wanted);
  const Motion rest{wanted.translation - along.translation, wanted.rotation - along.rotation};
  const Motion out{motion.translation - along.translation, motion.rotation - along.rotation};
  return blend(along, motion, share_within(rest, out, stretch, gyration_));
}

std::optional<Motion> ProxyForce::way_to(const Goal& goal, double stretch, Hold& held) {
  if (!view_around(goal)) return std::nullopt;
  const Motion wanted = motion_between(proxy_, goal.target);
  Motion motion;
  for (int k = 0; k < kMostTurns; ++k) {
    if (!find_obstacles() || !budget_.allows_motion(obstacles_.planes.size())) return std::nullopt;
    budget_.spend_on_motion(obstacles_.planes.size());
    motion = constrained_motion(wanted, obstacles_.planes, gyration_);
    held = hold();
    if (share_within(wanted, motion, stretch, gyration_) < 1.0) motion = less_wound(wanted, motion, stretch);
    if (held.push == 0.0) break;  // free along a way that has been viewed
    bool found = false;
    for (Part& part : parts_) {
      const std::size_t known = part.patches.added();
      if (!view_aside(part, motion, goal)) return std::nullopt;
      if (part.patches.added() == known) continue;
      part.aside.done = false;
      found = true;
    }
    if (!found) break;
  }
  view_anew();
  return motion;
}

void ProxyForce::view_anew() {
  for (Part& part : parts_)
    part.ready = part.ahead.done = part.aside.done = part.one_end.done = part.other_end.done = false;
}

double ProxyForce::way_of(const Motion& motion) const {
  return motion.translation.norm() + radius_ * motion.rotation.norm();
}

bool ProxyForce::is_free_around(const Pose& there, double way) {
  for (const Part& part : parts_) {
    scene_.scene().query(containing(part.solid.at(there), way), Precision::kSingle, contacts_,
                         {.contacts = 1});
    budget_.spend_on_touch(contacts_.filtered);
    if (!contacts_.contacts.empty()) return false;
  }
  return true;
}

double ProxyForce::cross_free_space(const Pose& target, double longest) {
  const auto knows_nothing = [](const Part& part) { return part.patches.patches().empty(); };
  if (!std::ranges::all_of(parts_, knows_nothing)) return 0.0;
  const Motion wanted = motion_between(proxy_, target);
  const double farthest = way_of(wanted);
  const double length = length_of(wanted, gyration_), all = std::min(1.0, longest / std::max(length, 1e-300));
  const auto at = [&](double share) { return after(proxy_, blend({}, wanted, share)); };
  double share = 0.0;
  for (double more = all; more * farthest > step_ && !budget_.is_half_spent();) {
    const double half = 0.5 * more;
    if (is_free_around(at(share + half), half * farthest)) {
      share += more;
      more = all - share;
    } else {
      more = half;
    }
  }
  if (share == 0.0) return 0.0;
  proxy_ = share == 1.0 ? target : at(share);
  held_ = waits_ = false;
  trails_ = trails_ && share < 1.0;
  view_anew();
  return share * length;
}

double ProxyForce::step(const Pose& target, double longest, double stretch) {
  if (!waits_) goal_ = {target, longest};
  Hold held;
  const std::optional<Motion> found = way_to(goal_, stretch, held);
  waits_ = !found;
  if (waits_) return 0.0;
  Motion motion = *found;
  held_ = held.push > 0.0;
  if (held_) {
    hold_ = held;  // kept while the spring relaxes after contact
    trails_ = true;
  }
  const double farthest = way_of(motion);
  const double length = length_of(motion, gyration_);
  const double share =
      std::min({1.0, step_ / std::max(farthest, 1e-300), goal_.longest / std::max(length, 1e-300)});
  if (share < 1.0) motion = blend({}, motion, share);
  if (!held_ && share == 1.0) {
    proxy_ = goal_.target;  // exactly, without rounding
    trails_ = false;
  } else {
    proxy_ = after(proxy_, motion);
  }
  for (MotionConstraint& plane : obstacles_.planes) plane.gap += plane.normal.dot(plane.of(motion));
  return share * length;
}

Motion ProxyForce::less_owed(const Motion& pull) {
  if (!held_ || owed_ == 0.0 || obstacles_.planes.size() > kMostPlanesSolved) return pull;
  const Motion rest = motion_along_planes({-pull.translation, -pull.rotation});
  const double share = std::min(1.0, owed_ / std::max(length_of(rest, gyration_), 1e-300));
  return {pull.translation + share * rest.translation, pull.rotation + share * rest.rotation};
}

Motion ProxyForce::smoothed(const Motion& pull, double most) const {
  if (!pull_) return pull;
  const Motion change{pull.translation - pull_->translation, pull.rotation - pull_->rotation};
  const double size = length_of(change, gyration_);
  return size > most ? blend(*pull_, pull, most / size) : pull;
}

LocalSurface ProxyForce::local() const {
  const std::vector<MotionConstraint>& planes = obstacles_.planes;
  const auto matters_more = [&](std::size_t a, std::size_t b) {
    return planes[a].push != planes[b].push ? planes[a].push > planes[b].push : planes[a].gap < planes[b].gap;
  };
  std::array<std::size_t, LocalSurface::kMost> chosen{};
  LocalSurface found;
  for (std::size_t i = 0; i < planes.size(); ++i) {
    std::size_t place = found.count;
    while (place > 0 && matters_more(i, chosen[place - 1])) --place;
    if (place == LocalSurface::kMost) continue;
    found.count = std::min(found.count + 1, LocalSurface::kMost);
    std::copy_backward(chosen.begin() + place, chosen.begin() + found.count - 1,
                       chosen.begin() + found.count);
    chosen[place] = i;
  }
  for (std::size_t k = 0; k < found.count; ++k) {
    const MotionConstraint& plane = planes[chosen[k]];
    found.planes[k] = {proxy_.position - plane.gap * plane.normal, plane.normal};
  }
  const bool any = found.count > 0;
  const Properties of = any ? obstacles_.properties[chosen[0]]
                            : Properties{parameters_.stiffness, parameters_.friction, 0.0, 1.0};
  found.stiffness = spring_.felt > 0.0 && trails_ ? spring_.stiffness : of.stiffness * of.confidence;
  found.damping = std::min(of.damping, damping_max_);
  found.friction = of.friction;
  return found;
}

/// Damping cancels the push at most, or doubles it: it is zero without a push, and never pulls.
double ProxyForce::damped(const Eigen::Vector3d& push) const {
  const double size = push.norm();
  const double damping = std::min(hold_.damping, damping_max_);
  if (damping == 0.0 || size == 0.0) return 1.0;
  const double outwards = velocity_.dot(push) / size;
  return std::clamp(1.0 - damping * outwards / size, 0.0, 2.0);
}

/// Less where the proxy moves to and fro, as between patches that alternate, so that it settles.
double ProxyForce::catch_up() const {
  return parameters_.hand_scale * kCatchUp * std::max(kLeastPurpose, direction_.squaredNorm());
}

double ProxyForce::most_reserve() const { return kReserve * parameters_.hand_scale * parameters_.hand_scale; }

void ProxyForce::remember(const Eigen::Vector3d& moved) {
  const double way = moved.norm();
  if (way == 0.0) return;
  const double forgotten = -std::expm1(-way / step_);
  direction_ += forgotten * (moved / way - direction_);
}

double ProxyForce::energy_left(const Motion& moved) const {
  const double p = -product(spring_.along, moved, gyration_);
  return std::max(0.0, 0.5 * spring_.stiffness * spring_.felt * (spring_.felt + p) + spring_.reserve);
}

void ProxyForce::release(const Motion& moved) {
  spring_.reserve = std::min(energy_left(moved), most_reserve());
  spring_.felt = 0.0;
}

/// With f the length of the spring that generates force, and p the tool's displacement away from the proxy,
/// along the spring,
///
///     k f^2 / 2 <= B + k f p / 2,    B = k' f'^2 / 2 + k' f' p' / 2 + reserve
///
/// with ' the values before, and B energy_left(): the force on the hand changes linearly from tick to tick.
void ProxyForce::wind(const Motion& pull, double length, const std::optional<Motion>& moved, double dt) {
  const Spring was = spring_;
  const double left = moved ? energy_left(*moved) : 0.0;
  double k = hold_.stiffness * hold_.confidence;
  if (moved && was.felt > 0.0) {
    const double stiffer = std::max(hold_.stiffness, was.stiffness);
    const double change = stiffer * parameters_.hand_scale * kSoften * dt / std::max(length, 1e-12);
    k = std::clamp(k, was.stiffness - change, was.stiffness + change);
  }
  spring_ = {.along = length > 0.0 ? blend({}, pull, 1.0 / length) : Motion{},
             .felt = length,
             .stiffness = k,
             .reserve = was.reserve};
  if (!moved) return;
  const double p = -product(spring_.along, *moved, gyration_);
  const double most = 0.5 * p + std::sqrt(0.25 * p * p + 2.0 * left / std::max(k, kLeastStiffness));
  spring_.felt = std::clamp(most, 0.0, length);
  spring_.reserve = std::clamp(left + 0.5 * k * spring_.felt * (p - spring_.felt), 0.0, most_reserve());
}

/// As remember(), for the motion of a part of the tool.
void ProxyForce::head(Part& part, const Eigen::Vector3d& moved) {
  const double way = moved.norm();
  if (way == 0.0) return;
  const double forgotten = -std::expm1(-way / (kHeadingOfTool * part.solid.semi_axes.minCoeff()));
  part.heading += forgotten * (moved / way - part.heading);
}

ForceOutput ProxyForce::evaluate(const ForceInput& input) {
  if (!scene_.follow()) {
    forget_surface();
    start_at_proxy();
    replaced_ = true;
  }
  if (!scene_.has_moved()) return evaluate_in_scene(input);
  ForceOutput output = in_world(scene_.X_WA(), evaluate_in_scene(in_anchor(scene_.X_WA(), input)));
  if (proxy_ == tool_) output.proxy = input.tool;  // exactly, without rounding
  return output;
}

ForceOutput ProxyForce::evaluate_in_scene(const ForceInput& input) {
  budget_.refill();
  const bool jumped =
      !trails_ && (input.tool.position - tool_.position).norm() > kJump * parameters_.hand_scale;
  if (!started_ || jumped) {
    reset();
    proxy_ = tool_ = input.tool;
    started_ = true;
    start_at_proxy();
  }
  const std::size_t started = starting_;
  const bool knows_all = start();
  if (replaced_ && starting_ > started) leave_known();
  if (!knows_all && !trails_) {
    tool_ = input.tool;
    return {Wrench{}, proxy_, 1.0, spring_.reserve, 0.0, 0.0, false, local(), false};
  }
  damping_max_ = input.damping_max;
  velocity_ += -std::expm1(-input.dt / kVelocityFilter) * (input.velocity.linear - velocity_);
  const Motion moved = motion_between(tool_, input.tool);
  const double of_tool = length_of(moved, gyration_);
  // A proxy that was never in contact is at the tool or on its way there; one that has lost contact follows
  // it.
  const double in_contact = of_tool + catch_up() * input.dt;
  double way = (held_ ? in_contact : std::max(in_contact, 2.0 * of_tool)) + owed_;
  const bool starts = steps_out_ > 0;
  // Where the tool starts inside an object, the proxy leaves it at once.
  if (!trails_ || replaced_ || starts) way = std::numeric_limits<double>::infinity();
  for (Part& part : parts_) head(part, part.solid.at(input.tool).center - part.solid.at(tool_).center);
  tool_ = input.tool;
  const Eigen::Vector3d before = proxy_.position;
  // The proxy leaves the object it started in before it follows the tool.
  const Pose target = starts && !replaced_ ? start_ : input.tool;
  // The length of the spring before the proxy moves, and how much longer it may get.
  const double slack = length_of(motion_between(proxy_, input.tool), gyration_);
  const double more = trails_ ? 2.0 * spring_.reserve / std::max(hold_.stiffness, kLeastStiffness) : 0.0;
  const double stretch = starts ? std::numeric_limits<double>::infinity() : std::sqrt(slack * slack + more);
  const int most_held = starts ? steps_out_ : kMostSteps;
  int held_steps = 0;
  bool settled = false;
  way -= cross_free_space(target, way);
  for (int k = 0; k < kMostFreeSteps && held_steps < most_held && way > 0.0 && knows_all; ++k) {
    const bool is_late = waits_;  // then it ends the step of the last tick
    const double gone = step(target, way, stretch);
    way -= gone;
    held_steps += held_ ? 1 : 0;
    settled = !is_late && !waits_ && gone < kSettled * step_;
    if (gone < kSettled * step_) break;
  }
  Motion pull = motion_between(input.tool, proxy_);
  owed_ = starts                ? length_of(motion_between(target, input.tool), gyration_)
          : trails_ && !settled ? std::clamp(way, 0.0, length_of(pull, gyration_))
                                : 0.0;
  steps_out_ = waits_ || !knows_all ? std::max(0, steps_out_ - held_steps) : 0;
  replaced_ = replaced_ && steps_out_ > 0;
  remember(proxy_.position - before);
  // No force on the way through free space.
  if (!trails_) {
    release(moved);
    pull_.reset();
    return {Wrench{}, proxy_, 1.0, spring_.reserve, 0.0, 0.0, false, local(), steps_out_ == 0};
  }
  if (!starts) pull = smoothed(less_owed(pull), 2.0 * of_tool + catch_up() * input.dt);
  pull_ = pull;
  const double length = length_of(pull, gyration_);
  wind(pull, length, starts ? std::nullopt : std::optional(moved), input.dt);
  if (spring_.felt == 0.0) return {Wrench{}, proxy_, 1.0, spring_.reserve, 0.0, 0.0, false, local()};
  const double k = spring_.stiffness, of_length = k * spring_.felt / length;
  const double push = of_length * damped(of_length * pull.translation);
  return {{push * pull.translation, push * gyration_ * gyration_ * pull.rotation},
          proxy_,
          hold_.confidence,
          0.5 * k * spring_.felt * spring_.felt + spring_.reserve,
          k,
          k * gyration_ * gyration_,
          false,
          local()};
}

}  // namespace palpate

/// \file
/// The constraint-based force: a proxy of the tool that stays on the surface.
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <vector>

#include <palpate/collision/contact_tracker.h>
#include <palpate/collision/scene_index.h>
#include <palpate/collision/splat_tracker.h>
#include <palpate/haptics/constrained_motion.h>
#include <palpate/haptics/force_model.h>
#include <palpate/haptics/look_budget.h>
#include <palpate/haptics/material.h>
#include <palpate/haptics/part_groups.h>
#include <palpate/haptics/surface_patches.h>
#include <palpate/haptics/tool.h>

namespace palpate {

/// Parameters of ProxyForce.
struct ProxyParameters {
  double stiffness = 500.0;  ///< of the spring between tool and proxy. Unit: [N/m]. >= 0
  double friction = 0.0;     ///< Coulomb's coefficient. >= 0
  /// Standard deviation of the kernel that a surface is fitted with; kDetailOfTool of the part's thinnest
  /// semi-axis if unset. Unit: [m]. > 0
  std::optional<double> detail = {};
  /// Metres of the world a metre of the hand's way: what is bounded for the hand's sake, speeds and energies,
  /// goes by the hand. > 0
  double hand_scale = 1.0;
  /// What the scene is made of, over the numbers above; null or empty: of one stuff all over.
  std::shared_ptr<const MaterialMap> materials = {};

  bool operator==(const ProxyParameters&) const = default;  ///< of materials: the same object

  /// A tool cannot tell much that is smaller than itself. This much of it keeps the direction of the force on
  /// splats a third of the tool's radius apart, displaced by a quarter of that, within four degrees, 95 times
  /// in 100.
  static constexpr double kDetailOfTool = 0.65;
};

/// Standard deviation of the kernel that a part of the tool feels the surface with. Unit: [m].
double detail_of(const ToolPart& part, const ProxyParameters& parameters);

/// How far around a part the scene is looked at: enough to see the window of a patch. Unit: [m]. \param
/// extent SceneIndex::usual_extent()
double reach_of(const ToolPart& part, double detail, double extent);

/// A part that is larger by `reach` on all sides, and so much larger that the window of a patch is in it
/// where the part touches: at the tip of a rod, too, right before which a body of longer semi-axes ends.
ToolPart enlarged(const ToolPart& part, double detail, double reach);

/// A god-object (Zilles and Salisbury 1995), in six degrees of freedom (Ortega, Redon and Coquillart 2007),
/// on a surface that is made of the contacts themselves where the proxy is (Ryden and Chizeck 2013 do so on
/// points):
///
///  1. every part of the proxy looks along the way it wants to go, along those of its ends where it
///     turns, and along the way that what holds it lets it go, for what it would touch first, and follows
///     the patches of surface that it has met (SurfacePatches). A patch begins only where an ellipsoid is
///     touched;
///  2. the proxy moves towards the tool as far as the patches let it (constrained_motion(), with
///     friction), at most half of the reach at once and never farther than it has looked, so that nothing
///     is passed unseen (tested up to 50 m/s); what a tick leaves undone, or has no budget to look at
///     (LookBudget), the next does. Where no part touches an ellipsoid all along a longer way, it goes that
///     way without a look;
///  3. again, until it hardly moves, at most kMostSteps times in contact, kMostFreeSteps times out of
///     contact. In contact it moves no farther than the tool did and a little, so that the force does not
///     jump where patches come and go;
///  4. what is there may change from one moment to the next, where a fit finds another patch, and push
///     the proxy away from the tool, which would wind up the spring with energy that no hand has put in.
///     The spring is therefore no longer after the proxy has moved than before, for the tool where it is,
///     but for a reserve that is filled by what the spring loses otherwise, kReserve at most. The proxy
///     stays in such a patch until the tool has made way;
///  5. force = k (x_proxy - x_tool), torque = k g^2 (turn from tool to proxy), g kTurning times the
///     tool's radius of gyration, or less, so that the spring holds no more than what the hand has put in
///     and the reserve: a stiffness that changes on the way does no work. Zero where nothing has held the
///     proxy since it was last with the tool. With damping b, the force changes by -b times the tool's
///     velocity along it, by no more than there is.
///
/// k is the stiffness of what holds the proxy times the confidence that it is there.
///
/// Stiffness, friction and damping are those of what holds the proxy: means over the Gaussians that the
/// surface is made of there, and over the patches, by how hard they are pushed.
///
/// Where another index is assigned to the one that it refers to (ContactQuery::epoch()), it forgets the
/// surface and starts anew where the proxy is, which comes out of what is there then, at once. A ball is
/// pushed by what moves towards it and not passed, at 1 mm from one epoch to the next and less (tested); what
/// moves by more than the tool's thinnest semi-axis may pass it. Friction starts anew, too: what moves drags
/// nothing along. Each epoch costs a start, 1 ms in the mean on a capture (decision 29). The reach is that of
/// the index it was made with.
///
/// The proxy is on the side it came from, however thin the surface and however deep the push. What it did is
/// its memory: an object serves one tool on one thread. Where a tool starts in something, some ticks may pass
/// without a force, until all of its parts have looked at what they are in, and some more until it is out.
/// Takes nothing from the heap after construction.
class ProxyForce final : public ForceModel {
 public:
  /// `index` and `lookahead` must outlive it; see ContactTracker.
  ProxyForce(const SceneIndex& index, const Tool& tool, const ProxyParameters& parameters = {},
             Lookahead* lookahead = nullptr);

  void reset() override;
  /// It looks for contacts where the proxy is.
  bool wants_contacts() const override { return false; }
  ForceOutput evaluate(const ForceInput& input) override;

  /// A turn counts by this many radii of gyration of the tool: a hand, or a device that does not turn, holds
  /// the direction of a tool more firmly than the inertia of a free body would. With one, the default tool
  /// falls over when it is pressed down on its end by more than its thickness, and a ball rolls two and a
  /// half times as far as friction lets it lag before it slips; with three, it stands, and the ball rolls a
  /// quarter.
  static constexpr double kTurning = 3.0;

  /// Of what the spring has lost, the most that the proxy may put back into it by moving away from the tool:
  /// what a fit of noisy splats goes up and down by as the tool slides. Unit: [J].
  static constexpr double kReserve = 2e-4;

  static constexpr int kMostSteps = 4;       ///< in contact
  static constexpr int kMostFreeSteps = 64;  ///< out of contact
  /// Pairs that are looked at, at once, to find what the tool has started in.
  static constexpr std::size_t kMostPairs = 4096;

 private:
  /// A look ahead.
  struct Sight {
    Ellipsoid from;
    Eigen::Vector3d along = Eigen::Vector3d::Zero();
    double clear = 0.0;  ///< how far the solid may go that way. Unit: [m].
    bool done = false;   ///< for the step that is to come
  };

  /// Where a part looks.
  struct Look {
    Eigen::Vector3d along, about;  ///< a unit vector, and the point of the part that goes first, world frame
    double way;                    ///< how far it goes there now. Unit: [m].
    bool arrives;                  ///< then it is where it wants to be
    double head_on = 0.0;          ///< see SurfacePatches::look_ahead()
  };

  /// Parts that look at the scene together.
  struct Group {
    Group(const SceneIndex& index, const ToolPart& around, bool single, Lookahead* lookahead,
          std::size_t capacity)
        : solid(around), is_single(single), splats(index, lookahead, capacity) {}

    ToolPart solid;  ///< around all of them, enlarged
    bool is_single;  ///< the part itself
    SplatTracker splats;
  };

  struct Part {
    Part(const SceneIndex& index, const ToolPart& part, const ProxyParameters& parameters, double extent,
         Lookahead* lookahead, std::size_t capacity, LookBudget& budget)
        : solid(part),
          reach(reach_of(part, detail_of(part, parameters), extent)),
          larger(enlarged(part, detail_of(part, parameters), reach)),
          touched(index, Precision::kDouble, lookahead, capacity),
          patches(detail_of(part, parameters), larger.semi_axes.cwiseQuotient(part.semi_axes), budget) {}

    void join(Group& joined, std::size_t capacity) {
      group = &joined;
      near = &joined.splats.newest();
      if (!joined.is_single) own = std::make_unique<LocalSplats>(capacity);
    }

    ToolPart solid;
    double reach;     ///< Unit: [m].
    ToolPart larger;  ///< by the reach
    Group* group = nullptr;
    const LocalSplats* near = nullptr;  ///< what it looks at: of its group, or its own
    std::unique_ptr<LocalSplats> own;   ///< those of its group that it may see; null where it is alone
    ContactTracker touched;
    SurfacePatches patches;
    /// Mean direction of the last way of the centre, over a quarter of the thinnest semi-axis; a unit vector
    /// if that was straight.
    Eigen::Vector3d heading = Eigen::Vector3d::Zero();
    Sight ahead;               ///< the way that the centre wants to go
    Sight aside;               ///< and the way that it goes, along what holds it
    Sight one_end, other_end;  ///< and the ends, where it turns
    bool ready = false;        ///< has looked all around for the step that is to come
    bool meets = false;        ///< its patches hold it in the step that is to come
  };

  /// Where a step goes.
  struct Goal {
    Pose target;           ///< X_WT
    double longest = 0.0;  ///< of the step. Unit: [m].
  };

  /// What something is made of, nothing left open.
  struct Properties {
    double stiffness, friction, damping;
    double confidence;  ///< that it is there
  };

  /// What the proxy must not enter, and what that is made of.
  struct Obstacles {
    std::vector<MotionConstraint> planes;
    std::vector<Properties> properties;
  };

  /// Of what holds the proxy, weighted by how hard it is pushed.
  struct Hold {
    double push = 0.0;  ///< in all; 0 if nothing does. Unit: [m].
    double confidence = 1.0;
    double stiffness = 0.0, damping = 0.0;
  };

  /// The last step: where the proxy went from, and how.
  struct Step {
    Eigen::Vector3d from = Eigen::Vector3d::Zero();  ///< of the handle, world frame
    Motion motion;
  };

  /// What the hand feels.
  struct Spring {
    Motion along;               ///< from tool to proxy, of length 1; zero where both are in one place
    double felt = 0.0;          ///< how much of its length. Unit: [m].
    double stiffness = 0.0;     ///< Unit: [N/m].
    double reserve = kReserve;  ///< what it may yet take in that is no work of the hand's. Unit: [J].
  };

  /// Moves the proxy one step towards `target`, by at most `longest`; or towards where it was to go when
  /// there was no time to look. \returns how far. Unit: [m].
  double step(const Pose& target, double longest, double stretch);
  /// Moves the proxy towards `target` as far as no part touches anything on all of the way, where that is
  /// farther than a step: what no ellipsoid is touched on needs no look. \returns how far. Unit: [m].
  double cross_free_space(const Pose& target, double longest);
  /// How far any point of the tool goes, at most. Unit: [m].
  double way_of(const Motion& motion) const;
  /// True if no part touches anything anywhere within `way` of where it is there.
  bool is_free_around(const Pose& there, double way);
  Motion less_wound(const Motion& wanted, const Motion& motion, double stretch);
  /// The motion towards the goal that what is seen allows, and what it is held by. \returns nothing if the
  /// budget did not allow to look at all of it: what has been looked at is not again when it is asked for the
  /// same goal.
  std::optional<Motion> way_to(const Goal& goal, double stretch, Hold& held);
  /// Forgets who has looked for the step that was to come.
  void look_anew();
  /// Follows the patches of all parts, and looks where they are about to go. \returns as look_ahead()
  bool look_around(const Goal& goal);
  /// Does so from one part. \returns as look_ahead()
  bool look_from(Part& part, const Goal& goal);
  /// Finds the Gaussians around a group, going through `most` of the index and a few besides. \returns false
  /// if there are more to go through
  bool search(Group& group, std::size_t most);
  /// The patches of all parts as obstacles.
  void find_obstacles();
  /// Forgets what is known of the scene, which may be another now; not where the proxy is, nor what it did.
  void forget_surface();
  /// What the proxy is in where it stands lets it out, as far as it takes.
  void start_at_proxy();
  /// Looks where `part` goes with that motion. \returns as look_ahead()
  bool look_aside(Part& part, const Motion& motion, const Goal& goal);
  /// Looks where `part` is about to go. \returns false if the budget was spent before.
  bool look_ahead(Part& part, const LocalSplats& splats, const Goal& goal);
  /// Of what is around its group, what `part` may see.
  void select_near(Part& part);
  /// The same for one direction.
  bool look_along(Part& part, Sight& sight, const LocalSplats& splats, const Look& look, const Pose& target);
  /// True if `part` touches an ellipsoid there.
  bool touches(Part& part, const Ellipsoid& solid);
  /// False if `part` is free, will be where it wants to be after this step, and touches nothing there: a
  /// contact begins only where the tool touches something, whatever patches the last one has left.
  bool may_meet(Part& part, const Goal& goal);
  /// Goes on with the parts that have not started yet. \returns false if there are some left
  bool start();
  /// Contacts of `part` there, as of ContactTracker, into contacts_.
  void find_contacts(Part& part, const Ellipsoid& solid, QueryLimit limit);
  /// The same, as a heap with the deepest at its top; where they are more than kMostPairs those of a smaller
  /// solid in its middle.
  void find_deepest(Part& part, const Ellipsoid& solid);
  /// Patches of what a part is in where it starts. \returns false if there was no time for all of it
  bool start_patches(Part& part, bool at_once);
  Properties properties_of(const SurfacePatches& patches, std::size_t i) const;
  Hold hold() const;
  /// The obstacles of the last step that matter most.
  LocalSurface local() const;
  /// How much faster than the tool the proxy may move now. Unit: [m/s].
  double catch_up() const;
  void remember(const Eigen::Vector3d& moved);
  void head(Part& part, const Eigen::Vector3d& moved);
  double most_reserve() const;
  /// Makes spring_ that of now, `pull` from tool to proxy. \param moved of the tool since the last time;
  /// nothing where it starts, and all of the spring is felt
  void wind(const Motion& pull, double length, const std::optional<Motion>& moved, double dt);
  /// What the push is multiplied with so that it damps the motion, too.
  double damped(const Eigen::Vector3d& push) const;

  const SceneIndex& index_;
  std::uint64_t epoch_;  ///< of what is known of it
  ProxyParameters parameters_;
  double gyration_;  ///< Unit: [m].
  double radius_;    ///< of the tool about its handle. Unit: [m].
  double step_;      ///< the farthest that a point moves at once. Unit: [m].
  LookBudget budget_;
  std::deque<Group> groups_;  ///< that cannot be moved
  std::deque<Part> parts_;    ///< nor can they
  ContactSet contacts_;
  Obstacles obstacles_;
  /// Mean direction of the proxy's last way, of the length of a step; a unit vector if that was straight.
  Eigen::Vector3d direction_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_ = Eigen::Vector3d::Zero();  ///< of the handle, filtered. Unit: [m/s].
  double damping_max_ = 0.0;                            ///< ForceInput::damping_max
  bool started_ = false;
  std::size_t starting_ = 0;  ///< the first part that has not looked where the tool has started
  bool knows_start_ = false;  ///< contacts_ are what it starts in and has not looked at
  int steps_out_ = 0;         ///< that the proxy may yet make out of what it has started in
  bool held_ = false;         ///< by something, in the last step
  bool trails_ = false;       ///< has been held since it was last with the tool
  bool replaced_ = false;     ///< the scene was, and the proxy is not out yet of what is there now
  bool waits_ = false;        ///< for the time to look where it goes
  double owed_ = 0.0;         ///< way that it could not go as it waited or came out of the start. Unit: [m].
  Goal goal_;                 ///< of the last step
  Hold hold_;                 ///< of the last step in which it was held
  Step step_taken_;
  Spring spring_;  ///< of the last call
  Pose tool_;      ///< of the last call, world frame
  Pose start_;     ///< where the proxy was when it started, world frame
  Pose proxy_;     ///< world frame
};

}  // namespace palpate

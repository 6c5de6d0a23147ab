/// \file
/// Constraint-based force model: a proxy of the tool that stays on the surface.
#pragma once

#include <cstddef>
#include <deque>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include <palpate/collision/contact_tracker.h>
#include <palpate/collision/scene_index.h>
#include <palpate/collision/splat_tracker.h>
#include <palpate/haptics/anchored_scene.h>
#include <palpate/haptics/constrained_motion.h>
#include <palpate/haptics/force_model.h>
#include <palpate/haptics/material.h>
#include <palpate/haptics/part_groups.h>
#include <palpate/haptics/surface_patches.h>
#include <palpate/haptics/tool.h>
#include <palpate/haptics/work_budget.h>

namespace palpate {

/// Parameters of ProxyForce.
struct ProxyParameters {
  double stiffness = 500.0;  ///< of the spring between tool and proxy. Unit: [N/m]. >= 0
  double friction = 0.0;     ///< Coulomb's coefficient. >= 0
  /// Standard deviation of the kernel that a surface is fitted with; kDetailOfTool of the part's shortest
  /// semi-axis if unset. Unit: [m]. > 0
  std::optional<double> detail = {};
  /// World metres per device metre: bounds on speed and energy that protect the hand apply at the device. > 0
  double hand_scale = 1.0;
  /// Upper bound of the arm g of torques, for a device that holds no stiffer spring about its axes
  /// (ServoTick::longest_arm()). Unit: [m]. > 0
  double arm_max = std::numeric_limits<double>::infinity();
  /// Materials of the scene, which override the parameters above; null or empty = uniform.
  std::shared_ptr<const MaterialMap> materials = {};

  bool operator==(const ProxyParameters&) const = default;  ///< materials: by identity

  /// A tool resolves little detail smaller than itself. With this fraction of its size, the direction of the
  /// force on splats a third of the tool's radius apart, displaced by a quarter of that, is accurate to four
  /// degrees in 95 % of cases.
  static constexpr double kDetailOfTool = 0.65;
};

/// Returns the standard deviation of the kernel with which a part of the tool fits the surface. Unit: [m].
double detail_of(const ToolPart& part, const ProxyParameters& parameters);

/// Returns the distance around a part within which the scene is viewed: enough for the window of a patch.
/// Unit: [m]. \param extent SceneIndex::usual_extent()
double reach_of(const ToolPart& part, double detail, double extent);

/// Returns a part enlarged by `reach` on all sides, and by enough that it contains the window of a patch at
/// every contact point, also at the tip of a rod, just beyond which a body of longer semi-axes ends.
ToolPart enlarged(const ToolPart& part, double detail, double reach);

/// Returns the number of Gaussians that a view of a part, enlarged, needs: those at a spacing of an eighth of
/// a detail over its largest cross-section, as far as a CandidateCache holds them. 1,500 for a ball; with two
/// thirds of them, pushes at a dense capture are silent (decision 31).
std::size_t enough_for(const ToolPart& part, double detail);

/// A god-object (Zilles and Salisbury 1995), in six degrees of freedom (Ortega, Redon and Coquillart 2007),
/// on a surface fitted to the scene around the proxy (Ryden and Chizeck 2013 do so on points):
///
///  1. every part of the proxy searches for the first surface along its intended motion, along the motions of
///     its ends where it rotates, and along the motion its constraints allow, and tracks the patches of
///     surface that it has met (SurfacePatches). A patch begins only where an ellipsoid is touched;
///  2. the proxy moves towards the tool as far as the patches allow (constrained_motion(), with friction), at
///     most half of the reach per step and never farther than it has viewed, so that it passes through
///     nothing (tested up to 50 m/s); work left over, or beyond the budget (WorkBudget), continues in the
///     next tick. A longer motion on which no part touches an ellipsoid is made without a view;
///  3. these steps are repeated until it hardly moves, at most kMostSteps times in contact, kMostFreeSteps
///     times out of contact. In contact it moves only slightly farther than the tool did, so that the force
///     does not jump where patches appear and disappear. What a tick has no time for is owed to the next, and
///     does not drag: the force is that of a proxy that had gone there along the planes that hold it (if
///     there are kMostPlanesSolved at most; decision 32);
///  4. the surface may change between ticks, where a fit finds another patch, and push the proxy away from
///     the tool, which would store energy in the spring that the hand has not put in. The motion of the proxy
///     therefore never lengthens the spring at a fixed tool pose, except by a reserve that is filled by the
///     energy the spring loses otherwise, kReserve at most. The proxy stays inside such a patch until the
///     tool has moved out of the way;
///  5. force = k (x_proxy - x_tool), torque = k g^2 (turn from tool to proxy), g kTurning times the tool's
///     radius of gyration, arm_max at most; or less, so that the stored energy is at most the hand's work
///     plus the reserve: a change of stiffness does no work. Zero if the proxy has met no constraint since it
///     last coincided with the tool. With damping b, the force changes by -b times the tool's velocity along
///     it, at most by its own magnitude.
///
/// k is the stiffness of the surface in contact with the proxy times its confidence.
///
/// Stiffness, friction and damping are those of that surface: means over the Gaussians of each patch, and
/// over the patches, weighted by their pushes.
///
/// Another index may be assigned to the referenced one between two calls (ContactQuery::epoch()). Where that
/// has the same Gaussians at another pose (SceneIndex::registered()), the scene has moved as a whole: all of
/// the above is then done in its frame, in which only the tool moves, so that a moving scene pushes the tool,
/// drags it by friction and is not passed, at the cost of a still one (AnchoredScene, decision 34). Damping
/// remains that of the tool's velocity in the world. With other Gaussians, or at another scale, the surface
/// is discarded and the model restarts at the proxy's pose, from which the proxy leaves the new surface at
/// once: 1 ms on average on a capture, and a surface that moves by more than the tool's shortest semi-axis
/// may pass it (decision 29). The reach remains that of the index at construction, and regions of materials
/// move with the scene.
///
/// The proxy stays on the side it came from, however thin the surface and however deep the push. Its path is
/// state: an object serves one tool on one thread. If a tool starts inside an object, some ticks may pass
/// without force until all of its parts have viewed the scene around them, and some more until it is out.
/// Does not allocate after construction.
class ProxyForce final : public ForceModel {
 public:
  /// `index` and `lookahead` must outlive it; see ContactTracker.
  ProxyForce(const SceneIndex& index, const Tool& tool, const ProxyParameters& parameters = {},
             Lookahead* lookahead = nullptr);

  void reset() override;
  /// False: the model searches for contacts at the proxy itself.
  bool wants_contacts() const override { return false; }
  ForceOutput evaluate(const ForceInput& input) override;

  /// Rotations are weighted by this many radii of gyration of the tool: a hand, or a device without rotation,
  /// holds the orientation of a tool more firmly than the inertia of a free body would. With 1, the default
  /// tool tips over when its end is pressed down by more than its thickness, and a ball rolls two and a half
  /// times as far as friction lets it lag before it slips; with 3, the tool stands, and the ball rolls a
  /// quarter as far as that lag.
  static constexpr double kTurning = 3.0;

  /// Largest part of the energy lost by the spring that the proxy may restore by moving away from the tool:
  /// the fluctuation of fits to noisy splats as the tool slides. Unit: [J].
  static constexpr double kReserve = 2e-4;

  static constexpr int kMostSteps = 4;       ///< in contact
  static constexpr int kMostFreeSteps = 64;  ///< out of contact
  /// Largest number of pairs examined at once to find the objects in which the tool starts.
  static constexpr std::size_t kMostPairs = 4096;

 private:
  /// A view ahead.
  struct Sight {
    Ellipsoid from;
    Eigen::Vector3d along = Eigen::Vector3d::Zero();
    double clear = 0.0;  ///< free travel of the solid in that direction. Unit: [m].
    bool done = false;   ///< viewed for the next step
  };

  /// Direction and focus of a view of a part.
  struct ViewRequest {
    Eigen::Vector3d along, about;  ///< a unit vector, and the point of the part that goes first, world frame
    double way;                    ///< how far it goes there now. Unit: [m].
    bool arrives;                  ///< then it is where it wants to be
    double head_on = 0.0;          ///< see SurfacePatches::view_ahead()
  };

  /// Parts that share one search of the scene.
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
         Lookahead* lookahead, std::size_t capacity, WorkBudget& budget)
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
    const LocalSplats* near = nullptr;  ///< Gaussians it views: of its group, or its own
    std::unique_ptr<LocalSplats> own;   ///< subset of the group's that it may see; null if single
    ContactTracker touched;
    SurfacePatches patches;
    /// Mean direction of recent motion of the centre, over a quarter of the shortest semi-axis; a unit vector
    /// if straight.
    Eigen::Vector3d heading = Eigen::Vector3d::Zero();
    Sight ahead;               ///< the way that the centre wants to go
    Sight aside;               ///< and the way that it goes, along what holds it
    Sight one_end, other_end;  ///< and the ends, where it turns
    bool ready = false;        ///< has looked all around for the step that is to come
    bool meets = false;        ///< its patches hold it in the step that is to come
  };

  /// Goal of a step.
  struct Goal {
    Pose target;           ///< X_WT
    double longest = 0.0;  ///< of the step. Unit: [m].
  };

  /// Complete material properties.
  struct Properties {
    double stiffness, friction, damping;
    double confidence;  ///< that it is there
  };

  /// Constraints of the proxy and their material properties.
  struct Obstacles {
    std::vector<MotionConstraint> planes;
    std::vector<Properties> properties;
  };

  /// Properties of the surface in contact with the proxy, weighted by push.
  struct Hold {
    double push = 0.0;  ///< total; 0 without contact. Unit: [m].
    double confidence = 1.0;
    double stiffness = 0.0, damping = 0.0;
  };

  /// Spring between tool and proxy that is rendered.
  struct Spring {
    Motion along;               ///< from tool to proxy, of length 1; zero where both are in one place
    double felt = 0.0;          ///< length that generates force. Unit: [m].
    double stiffness = 0.0;     ///< Unit: [N/m].
    double reserve = kReserve;  ///< energy it may still gain without work of the hand. Unit: [J].
  };

  /// evaluate(), with input and output in the anchor frame of the scene.
  ForceOutput evaluate_in_scene(const ForceInput& input);
  /// Moves the proxy one step towards `target`, by at most `longest`; or towards the previous goal if the
  /// budget ran out before it was viewed. \returns the distance moved. Unit: [m].
  double step(const Pose& target, double longest, double stretch);
  /// Returns `pull`, from the tool to the proxy, less the way that the proxy owes, along the planes that hold
  /// it: what a tick has no time for does not drag.
  Motion less_owed(const Motion& pull);
  /// Returns `pull`, or as much of its change since the last call as `most` permits. Unit: [m].
  Motion smoothed(const Motion& pull, double most) const;
  /// Moves the proxy towards `target` as far as no part touches anything, if that is farther than a step:
  /// motion without touching an ellipsoid needs no view. \returns the distance moved. Unit: [m].
  double cross_free_space(const Pose& target, double longest);
  /// Upper bound of the displacement of any point of the tool. Unit: [m].
  double way_of(const Motion& motion) const;
  /// Returns true if no part touches anything within `way` of its place with the tool at `there`.
  bool is_free_around(const Pose& there, double way);
  Motion motion_along_planes(const Motion& wanted);
  Motion less_wound(const Motion& wanted, const Motion& motion, double stretch);
  /// Returns the constrained motion towards the goal, and sets `held` to the contact. \returns nothing if the
  /// budget did not suffice for all views: completed views are not repeated when it is called again for the
  /// same goal.
  std::optional<Motion> way_to(const Goal& goal, double stretch, Hold& held);
  /// Discards the views made for the next step.
  void view_anew();
  /// Tracks the patches of all parts, and views the scene along their intended motions. \returns as
  /// view_ahead()
  bool view_around(const Goal& goal);
  /// Does the same for one part. \returns as view_ahead()
  bool view_from(Part& part, const Goal& goal);
  /// Finds the Gaussians around a group, visiting about `most` Gaussians of the index. \returns false if
  /// there are more to visit
  bool search(Group& group, std::size_t most);
  /// Collects the patches of all parts as obstacles. \returns false if the budget did not suffice to find all
  /// of their materials, and some are uniform yet: those found are not looked for again
  bool find_obstacles();
  /// Discards all knowledge of the scene, which may have been replaced; keeps the pose and history of the
  /// proxy.
  void forget_surface();
  /// Restarts at the proxy's pose, and permits the motion needed to leave what it is inside of.
  void start_at_proxy();
  /// Views the scene along the motion of `part`. \returns as view_ahead()
  bool view_aside(Part& part, const Motion& motion, const Goal& goal);
  /// Views the scene along the intended motion of `part`. \returns false if the budget was spent first.
  bool view_ahead(Part& part, const LocalSplats& splats, const Goal& goal);
  /// Selects the Gaussians of its group that `part` may see.
  void select_near(Part& part);
  /// As view_ahead(), for one direction.
  bool view_along(Part& part, Sight& sight, const LocalSplats& splats, const ViewRequest& request,
                  const Pose& target);
  /// Returns true if `part`, as `solid`, touches an ellipsoid.
  bool touches(Part& part, const Ellipsoid& solid);
  /// Returns false if `part` is free, reaches its target in this step, and touches nothing there: a contact
  /// begins only where the tool touches something, whatever patches remain of the last one.
  bool may_meet(Part& part, const Goal& goal);
  /// Continues with the parts that have not started yet. \returns false if some are left
  bool start();
  /// Moves the proxy out of what the parts that have started are in, without a view: a motion shorter than
  /// they are deep reaches nothing that they do not touch.
  void leave_known();
  /// Finds the contacts of `part`, as `solid`, into contacts_; see ContactTracker.
  void find_contacts(Part& part, const Ellipsoid& solid, QueryLimit limit);
  /// The same, as a heap with the deepest on top; if there are more than kMostPairs, those of a smaller
  /// concentric solid.
  void find_deepest(Part& part, const Ellipsoid& solid);
  /// Adds patches of the objects in which a part starts. \returns false if the budget did not suffice
  bool start_patches(Part& part, bool at_once);
  /// Finds the material of patch `i` if that is not known. \returns false if the budget did not suffice
  bool find_material(SurfacePatches& patches, std::size_t i);
  Properties properties_of(const SurfacePatch& patch) const;
  Hold hold() const;
  /// Returns the obstacles of the last step with the largest pushes, then the least gaps.
  LocalSurface local() const;
  /// Returns by how much the proxy may be faster than the tool now. Unit: [m/s].
  double catch_up() const;
  void remember(const Eigen::Vector3d& moved);
  void head(Part& part, const Eigen::Vector3d& moved);
  double most_reserve() const;
  /// Returns what the last force leaves of the energy of spring and reserve: it fades out while the tool
  /// moves by `moved`. Unit: [J].
  double energy_left(const Motion& moved) const;
  /// Ends the force, as the proxy is at the tool.
  void release(const Motion& moved);
  /// Updates spring_, with `pull` from tool to proxy. \param moved motion of the tool since the last call;
  /// nothing at the start, where the full length generates force
  void wind(const Motion& pull, double length, const std::optional<Motion>& moved, double dt);
  /// Returns the factor on the push that adds damping of the motion.
  double damped(const Eigen::Vector3d& push) const;

  AnchoredScene scene_;
  ProxyParameters parameters_;
  double gyration_;  ///< Unit: [m].
  double radius_;    ///< radius of the tool about its handle. Unit: [m].
  double step_;      ///< largest displacement of a point per step. Unit: [m].
  WorkBudget budget_;
  std::deque<Group> groups_;  ///< not movable
  std::deque<Part> parts_;    ///< likewise
  ContactSet contacts_;
  Obstacles obstacles_;
  /// Mean direction of the proxy's recent motion, over the length of a step; a unit vector if straight.
  Eigen::Vector3d direction_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_ = Eigen::Vector3d::Zero();  ///< of the handle, filtered. Unit: [m/s].
  double damping_max_ = 0.0;                            ///< ForceInput::damping_max
  bool started_ = false;
  std::size_t first_ = 0;     ///< the part that starts first: one that had no time before
  std::size_t starting_ = 0;  ///< number of parts that have viewed the scene at the start
  bool knows_start_ = false;  ///< contacts_ holds contacts at the start not yet viewed
  int steps_out_ = 0;         ///< remaining steps out of the objects it started in
  bool held_ = false;         ///< in contact in the last step
  bool trails_ = false;       ///< in contact since it last coincided with the tool
  bool replaced_ = false;     ///< scene replaced, and the proxy still inside the new one
  bool waits_ = false;        ///< for budget to view its way
  double owed_ = 0.0;  ///< distance that the last tick had no time for, or made while it started. Unit: [m].
  Goal goal_;          ///< of the last step
  Hold hold_;          ///< of the last step in contact
  Spring spring_;      ///< of the last call
  std::optional<Motion> pull_;  ///< from the tool to the proxy, in the last call; none if that was free
  Pose tool_;                   ///< of the last call, world frame
  Pose start_;                  ///< where the proxy was when it started, world frame
  Pose proxy_;                  ///< world frame
};

}  // namespace palpate

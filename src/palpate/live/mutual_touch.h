/// \file
/// Contact forces between the tools of several hands.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <vector>

#include <palpate/base/triple_buffer.h>
#include <palpate/haptics/force_model.h>
#include <palpate/haptics/tool.h>

namespace palpate {

/// Contact forces between the tools of several hands, as moving ellipsoids that repel each other.
///
/// Where an ellipsoid of one tool overlaps one of another (exact test, see KFunction), both hands get the
/// force
///
///     f = k depth n,    1 / k = 1 / k_a + 1 / k_b,
///
/// with depth and n of Contact and k_a, k_b the surface stiffness of each hand: two springs in series. The
/// force acts at Contact::point, is zero at first touch, and is equal and opposite except for the delay of
/// one tick with which each hand knows the other's pose.
///
/// A hand whose force is off (stopped, paused, in a fault, waiting at the start gate) neither exerts nor
/// receives forces, and while its force rises, both get that fraction. Tools that
/// overlap when a hand starts or returns do not push until they have been apart once: the sudden overlap
/// would otherwise release energy that nobody has put in. A hand whose loop hangs is felt at its last pose.
///
/// Of two tools, the kMostPairs pairs of parts whose bounding spheres overlap most are examined in a tick,
/// the same ones by both hands. Where there are more, others exert no force, and the tools count as
/// overlapping, so that they do not begin to push.
///
/// Threads: around() is called where models are created; all else runs inside these models on the servo
/// thread of each hand, without allocation, locks or waiting.
class MutualTouch {
 public:
  /// Pairs of parts of two tools examined in a tick: all of tools of up to 16 parts.
  static constexpr std::size_t kMostPairs = 256;

  explicit MutualTouch(std::size_t hands);

  /// Returns `model` of hand `hand` with `tool`, with the forces from the other hands added. `model` and this
  /// object must outlive it. Only one model of a hand may be in use at a time. Any thread. \param stiffness k
  /// of this hand. Unit: [N/m].
  std::unique_ptr<ForceModel> around(std::size_t hand, ForceModel& model, const Tool& tool, double stiffness);

 private:
  class Touching;

  /// Pose and tool of a hand.
  struct Place {
    Pose pose;                   ///< X_WT
    const Tool* tool = nullptr;  ///< from kept_
    double radius = 0.0;         ///< Tool::radius() of it. Unit: [m].
    double stiffness = 0.0;      ///< Unit: [N/m].
    double force_scale = 1.0;    ///< ForceInput::force_scale
    std::uint64_t presence = 0;  ///< from 1, changes whenever the hand returns; 0: absent
  };
  /// Channel from one hand to another.
  struct Link {
    TripleBuffer<Place> place;
    // Used by the thread of the receiving hand:
    std::uint64_t presence = 0;  ///< of the place that was read last
    bool were_apart = false;     ///< since both have been present
  };

  const Tool& keep(const Tool& tool);
  Link& link(std::size_t from, std::size_t to) { return links_[from * hands_ + to]; }
  void enter(std::size_t hand, Place place);
  void leave(std::size_t hand);
  void push(std::size_t hand, const Place& own, ForceOutput& felt);
  static bool push_pair(const Place& low, const Place& high, double sign, bool pushes, const Pose& handle,
                        ForceOutput& felt);

  std::size_t hands_;
  std::unique_ptr<Link[]> links_;        ///< hands_ x hands_, the diagonal unused
  std::vector<std::uint64_t> presence_;  ///< used by each hand's thread: its last Place::presence
  std::vector<std::uint8_t> is_there_;   ///< used by each hand's thread: whether the hand is present
  std::mutex mutex_;                     ///< guards the members below
  std::deque<Tool> kept_;  ///< all tools so far: a hand may still read one that the other has replaced
};

}  // namespace palpate

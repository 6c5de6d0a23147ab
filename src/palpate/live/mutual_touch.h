/// \file
/// Hands that feel each other's tools.
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

/// Where the tools of several hands are, for each other: moving ellipsoids that repel.
///
/// Where an ellipsoid of one tool overlaps one of another (exactly: see KFunction), both hands get the force
///
///     f = k depth n,    1 / k = 1 / k_a + 1 / k_b,
///
/// with depth and n of Contact and k_a, k_b the stiffness that each hand's surfaces have: two springs, one
/// behind the other. It acts at Contact::point, is zero at first touch, and is equal and opposite but for the
/// tick by which either knows the other's pose late.
///
/// A hand whose force is off (stopped, paused, in a fault) is not felt, and feels nobody. Tools that overlap
/// when a hand comes back, or begins, do not push until they have been apart once: what was put around them
/// in no time would otherwise set free energy that nobody has put in. A hand whose loop stands still is felt
/// where it was.
///
/// Threads: around() belongs to who makes models; the rest is done by these on the servo thread of each hand,
/// which takes nothing from the heap, locks nothing and waits for nobody.
class MutualTouch {
 public:
  explicit MutualTouch(std::size_t hands);

  /// What hand `hand` feels with `tool` where it feels `model`, which must outlive it, as this must. One
  /// model of a hand at a time is used. Any thread. \param stiffness k of this hand. Unit: [N/m].
  std::unique_ptr<ForceModel> around(std::size_t hand, ForceModel& model, const Tool& tool, double stiffness);

 private:
  class Touching;

  /// Where a hand is.
  struct Place {
    Pose pose;                   ///< X_WT
    const Tool* tool = nullptr;  ///< one that is kept
    double radius = 0.0;         ///< of it. Unit: [m].
    double stiffness = 0.0;      ///< Unit: [N/m].
    std::uint64_t presence = 0;  ///< from 1, another whenever it comes back; 0: it is not there
  };
  /// From one hand to another.
  struct Link {
    TripleBuffer<Place> place;
    // Of the thread of the other:
    std::uint64_t presence = 0;  ///< of the place that was looked at last
    bool were_apart = false;     ///< since both are there
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
  std::vector<std::uint64_t> presence_;  ///< of each hand's thread: the last number it was there under
  std::vector<std::uint8_t> is_there_;   ///< likewise
  std::mutex mutex_;                     ///< of what follows
  std::deque<Tool> kept_;  ///< all there were: a hand may still look at one that the other has no longer
};

}  // namespace palpate

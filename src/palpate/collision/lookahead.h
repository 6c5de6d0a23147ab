/// \file
/// Looking for contacts before the tool is there, on another thread.
#pragma once

#include <atomic>
#include <cstdint>
#include <deque>
#include <optional>

#include <palpate/base/background_work.h>
#include <palpate/base/triple_buffer.h>
#include <palpate/collision/candidate_cache.h>

namespace palpate {

/// Fills the CandidateCaches of tools that move, with a margin, for ContactTrackers on a servo thread, which
/// evaluate them at the pose of every tick (the paper's decoupling, section IV, without its stale force).
///
/// A neighbourhood reaches as far as the tool will move until the next but one is there, going on as it did,
/// and at least kLeastMargin on all sides; less where that is too much to go through in a tick.
///
/// add() before the threads begin. One thread calls take() and finish(); one calls want() and newest().
///
/// The index of a line may become another. The thread that looks ahead never reads the object that trackers
/// refer to: it has a copy, which shares the memory. A tracker that finds another epoch hands over the next
/// copy, one at a time: once the one before has been taken. What is found is of the epoch of a copy, and
/// covers nothing of another (CandidateCache::covers()). Copies are let go of by the thread that looks ahead,
/// never by that of the trackers, however much memory goes with the last one.
class Lookahead final : public BackgroundWork {
 public:
  /// Between a tracker and the thread that looks ahead for it.
  class Line {
   public:
    /// Of contacts in that precision; none: of what is drawn, see CandidateCache::search_drawn().
    /// \param capacity see CandidateCache
    Line(const SceneIndex& index, std::optional<Precision> precision, std::size_t capacity)
        : told_(index.epoch()), index_(index), taken_(told_), precision_(precision), found_(capacity) {}

    /// \name The servo thread's. Neither waits, nor takes memory or gives it back.
    /// @{
    /// What is near `tool` in `index`, which is read no longer than the call takes.
    void want(const SceneIndex& index, const Ellipsoid& tool);
    /// What was found last; the same until the next call of want().
    CandidateCache& newest() { return found_.front(); }
    /// @}

   private:
    friend class Lookahead;
    void take();
    void finish();

    /// On its way to the thread that looks ahead; empty where there is none.
    TripleBuffer<std::optional<SceneIndex>> next_;
    std::uint64_t told_;                ///< epoch of the last index that was handed over; the servo thread's
    SceneIndex index_;                  ///< the last that was taken
    std::atomic<std::uint64_t> taken_;  ///< its epoch
    std::uint64_t known_in_ = 0;        ///< epoch of the last search
    std::optional<Precision> precision_;
    TripleBuffer<Ellipsoid> wanted_;
    TripleBuffer<CandidateCache> found_;
    Ellipsoid tool_;                                 ///< that was taken
    Eigen::Vector3d way_ = Eigen::Vector3d::Zero();  ///< since the one before. Unit: [m].
    double farthest_ = 0.0;  ///< that any of its points moved on that way, at most. Unit: [m].
    bool started_ = false;
    Ellipsoid known_;      ///< the tool that was searched around last
    double margin_ = 0.0;  ///< of that search; 0 if there was none. Unit: [m].
  };

  /// A line for tools in `index`, of which it has a copy.
  Line& add(const SceneIndex& index, Precision precision, std::size_t capacity = CandidateCache::kCapacity) {
    return lines_.emplace_back(index, precision, capacity);
  }
  /// The same, for what is drawn.
  Line& add_drawn(const SceneIndex& index, std::size_t capacity = CandidateCache::kCapacity) {
    return lines_.emplace_back(index, std::nullopt, capacity);
  }

  void take() override;
  void finish() override;

  /// What a hand moves in a twentieth of a second from rest. Unit: [m].
  static constexpr double kLeastMargin = 0.01;
  /// Gaussians that are gone through in 10 us or so.
  static constexpr std::size_t kEasy = 1024;

 private:
  std::deque<Line> lines_;  ///< that cannot be moved
};

}  // namespace palpate

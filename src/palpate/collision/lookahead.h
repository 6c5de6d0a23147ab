/// \file
/// Candidate search ahead of the tool on a background thread.
#pragma once

#include <atomic>
#include <cstdint>
#include <deque>
#include <optional>

#include <palpate/base/background_work.h>
#include <palpate/base/triple_buffer.h>
#include <palpate/collision/candidate_cache.h>

namespace palpate {

/// Fills the CandidateCaches of moving tools, with a margin, for ContactTrackers on a servo thread, which
/// evaluate them at the pose of every tick (the paper's decoupling, section IV, without its stale force).
///
/// A neighbourhood extends as far as the tool, extrapolated from its last motion, will move until the next
/// but one is available, and at least kLeastMargin on all sides; less where it holds too many Gaussians to
/// process in a tick.
///
/// Call add() before the threads start. One thread calls take() and finish(); one calls want() and newest().
///
/// The index of a line may be replaced. The lookahead thread never reads the object that trackers refer to:
/// it has a copy, which shares the memory. A tracker that sees a new epoch hands over a copy, one at a time:
/// only after the previous one has been taken. Results belong to the epoch of the copy they were found in and
/// cover no other (CandidateCache::covers()). Copies are released by the lookahead thread, never by the
/// trackers' thread, however much memory the last one frees.
class Lookahead final : public BackgroundWork {
 public:
  /// Channel between a tracker and the thread that searches for it.
  class Line {
   public:
    /// \param precision of the contacts; unset: search what is drawn, see CandidateCache::search_drawn().
    /// \param capacity see CandidateCache
    Line(const SceneIndex& index, std::optional<Precision> precision, std::size_t capacity)
        : told_(index.epoch()), index_(index), taken_(told_), precision_(precision), found_(capacity) {}

    /// \name Servo thread only. Neither blocks, allocates or frees memory.
    /// @{
    /// Requests what is near `tool` in `index`, which is read only during the call.
    void want(const SceneIndex& index, const Ellipsoid& tool);
    /// The newest result; unchanged until the next call of want().
    CandidateCache& newest() { return found_.front(); }
    /// @}

   private:
    friend class Lookahead;
    void take();
    void finish();

    /// Index in transit to the lookahead thread; empty if there is none.
    TripleBuffer<std::optional<SceneIndex>> next_;
    std::uint64_t told_;                ///< epoch of the last index handed over; servo thread only
    SceneIndex index_;                  ///< last index taken
    std::atomic<std::uint64_t> taken_;  ///< its epoch
    std::uint64_t known_in_ = 0;        ///< epoch of the last search
    std::optional<Precision> precision_;
    TripleBuffer<Ellipsoid> wanted_;
    TripleBuffer<CandidateCache> found_;
    Ellipsoid tool_;                                 ///< last tool taken
    Eigen::Vector3d way_ = Eigen::Vector3d::Zero();  ///< displacement since the previous tool. Unit: [m].
    double farthest_ = 0.0;  ///< bound on the motion of any of its points meanwhile. Unit: [m].
    bool started_ = false;
    Ellipsoid known_;      ///< tool of the last search
    double margin_ = 0.0;  ///< of that search; 0 if there was none. Unit: [m].
  };

  /// Adds a line for tools in `index`, of which it keeps a copy.
  Line& add(const SceneIndex& index, Precision precision, std::size_t capacity = CandidateCache::kCapacity) {
    return lines_.emplace_back(index, precision, capacity);
  }
  /// Adds a line for what is drawn.
  Line& add_drawn(const SceneIndex& index, std::size_t capacity = CandidateCache::kCapacity) {
    return lines_.emplace_back(index, std::nullopt, capacity);
  }

  void take() override;
  void finish() override;

  /// Displacement of a hand in a twentieth of a second from rest. Unit: [m].
  static constexpr double kLeastMargin = 0.01;
  /// Number of Gaussians that are processed in about 10 us.
  static constexpr std::size_t kEasy = 1024;

 private:
  std::deque<Line> lines_;  ///< a deque, as lines cannot be moved
};

}  // namespace palpate

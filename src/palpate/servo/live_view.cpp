#include <palpate/servo/live_view.h>

#include <algorithm>

namespace palpate {

void LiveView::add(const TickRecord& record) {
  totals_.contact_ticks += record.contacts != 0 ? 1 : 0;
  totals_.contacts_max = std::max<std::uint64_t>(totals_.contacts_max, record.contacts);
  totals_.force_max = std::max(totals_.force_max, record.sent.force.norm());
  totals_.port_energy = record.port_energy;
  if (record.margin > 0.0)
    totals_.margin_min =
        totals_.margin_min > 0.0 ? std::min(totals_.margin_min, record.margin) : record.margin;
}

void LiveView::remember(const TickRecord& record) {
  const std::size_t n = remembered_.load(std::memory_order_relaxed);
  if ((record.state != totals_.state || record.fault != fault_) && n < kRemembered) {
    transitions_[n] = {record.t, record.state, record.fault};
    remembered_.store(n + 1, std::memory_order_release);
  }
  totals_.state = record.state;
  fault_ = record.fault;
}

bool LiveView::update() {
  const bool ticked = newest_.update();
  auto& [record, times, totals] = newest_.front();
  if (!stall_.apply(record)) return ticked;
  totals.state = record.state;
  return true;
}

void LiveView::see(const TickRecord& record, const TickTimes& times) {
  stall_.clear();
  add(record);
  ends_ = ends_ || record.fault == Fault::kEnded;
  if (!ends_) remember(record);
  newest_.back() = {record, times, totals_};
  newest_.publish();
}

}  // namespace palpate

#include <palpate/record/run_row.h>

#include <cmath>

#include <palpate/servo/servo_loop.h>

namespace palpate {

RunRow run_row(const TickRecord& record, const TickTimes& times) {
  constexpr double kMicro = 1e6;
  RunRow row;
  row.t = record.t;
  row.tool = record.tool;
  row.candidates = record.candidates;
  row.filtered = record.filtered;
  row.colliding = record.contacts;
  row.k_max = record.k_max;
  row.wrench = record.felt.wrench;
  row.proxy = record.felt.proxy.position;
  row.compute_us = kMicro * times.compute;
  if (record.reading.user) row.user_force = record.map.rotation * record.reading.user->force;
  const double stored = std::isnan(record.felt.stored_energy) ? 0.0 : record.felt.stored_energy;
  row.live =
      LiveColumns{record.velocity, record.sent_world,    record.state,  record.fault,      record.energy,
                  stored,          record.added_damping, record.margin, kMicro * times.age};
  return row;
}

}  // namespace palpate

// A client that is the device.

import { Topic } from 'roslib';

export const pose = (x, y, z, stamp = 0) => ({
  header: { seq: 0, stamp: { secs: 0, nsecs: stamp }, frame_id: 'world' },
  pose: { position: { x, y, z }, orientation: { x: 0, y: 0, z: 0, w: 1 } },
});

/// Publishes poses a millisecond apart until `over`, and what comes back to `hear`, with how long it took in ms. `path`
/// gives positions at times in s.
export async function drive(ros, path, over, hear, compression = 'none') {
  const hand = new Topic({ ros, name: '/palpate/client/measured_cp', messageType: 'geometry_msgs/PoseStamped' });
  hand.advertise();
  const force = new Topic({ ros, name: '/palpate/client/servo_cf', messageType: 'geometry_msgs/WrenchStamped', compression });
  const sent = new Map();
  force.subscribe((message) => {
    const key = message.header.stamp.nsecs;
    if (!sent.has(key)) return;
    hear(message.wrench.force, performance.now() - sent.get(key));
    sent.delete(key);
  });
  const begin = performance.now();
  for (let k = 1; !over(); k += 1) {
    while (performance.now() < begin + k) await new Promise((done) => { setImmediate(done); });
    sent.set(k, performance.now());
    hand.publish(pose(...path((performance.now() - begin) / 1000), k));
  }
  force.unsubscribe();
  hand.unadvertise();
}

/// The value below which that share of `values` is.
export function quantile(values, share) {
  const sorted = [...values].sort((a, b) => a - b);
  return sorted[Math.floor(share * (sorted.length - 1))];
}

#include <palpate/kinematics/chain_file.h>

namespace palpate {

// Vertical reach: the shoulder is 1.8 m up and the arm 1.05 m long, so the TCP moves from 0.8 m to above a
// person's head. The wrist's axes are perpendicular at rest, as in a gimbal, and the limits of the second
// keep them from becoming coplanar; those of the elbow keep it from being straight.
std::string_view giant_chain_text() {
  return R"(# A room-scale haptic device similar to HapticGiant, with the same room of 4.7 m x 5.5 m.
# All other values are assumed. Springs and counterweights are assumed to balance gravity: `effort` is the
# force or torque that the motors have left for motion.
name = "giant"
base = "room"
tip = "handle"

[[link]]
name = "room"

[[link]]
name = "bridge"
mass = 60.0
inertia = [150.0, 2.0, 150.0, 0.0, 0.0, 0.0]

[[link]]
name = "column"
mass = 30.0
center = [0.0, 0.0, -0.3]
inertia = [3.0, 3.0, 0.5, 0.0, 0.0, 0.0]

[[link]]
name = "shoulder"
mass = 8.0
inertia = [0.05, 0.05, 0.04, 0.0, 0.0, 0.0]

[[link]]
name = "upper_arm"
mass = 5.0
center = [0.0, 0.0, -0.2]
inertia = [0.09, 0.09, 0.01, 0.0, 0.0, 0.0]

[[link]]
name = "forearm"
mass = 3.0
center = [0.0, 0.0, -0.2]
inertia = [0.05, 0.05, 0.005, 0.0, 0.0, 0.0]

[[link]]
name = "wrist_1"
mass = 0.8
inertia = [0.0015, 0.0015, 0.0015, 0.0, 0.0, 0.0]

[[link]]
name = "wrist_2"
mass = 0.6
inertia = [0.001, 0.001, 0.001, 0.0, 0.0, 0.0]

[[link]]
name = "wrist_3"
mass = 0.4
center = [0.0, 0.0, -0.05]
inertia = [0.001, 0.001, 0.0005, 0.0, 0.0, 0.0]

[[link]]
name = "handle"

[[joint]]
name = "x"
type = "prismatic"
parent = "room"
child = "bridge"
axis = [1.0, 0.0, 0.0]
position = [0.0, 0.0, 2.6]
lower = -2.35
upper = 2.35
velocity = 2.0
acceleration = 8.0
effort = 1800.0

[[joint]]
name = "y"
type = "prismatic"
parent = "bridge"
child = "column"
axis = [0.0, 1.0, 0.0]
lower = -2.75
upper = 2.75
velocity = 2.0
acceleration = 8.0
effort = 1200.0

[[joint]]
name = "yaw"
type = "revolute"
parent = "column"
child = "shoulder"
axis = [0.0, 0.0, 1.0]
position = [0.0, 0.0, -0.8]
lower = -2.9
upper = 2.9
velocity = 4.0
acceleration = 30.0
effort = 1080.0

[[joint]]
name = "shoulder_pitch"
type = "revolute"
parent = "shoulder"
child = "upper_arm"
axis = [0.0, 1.0, 0.0]
lower = -0.6
upper = 2.6
rest = 0.8
velocity = 4.0
acceleration = 30.0
effort = 1080.0

[[joint]]
name = "elbow"
type = "revolute"
parent = "upper_arm"
child = "forearm"
axis = [0.0, 1.0, 0.0]
position = [0.0, 0.0, -0.45]
lower = -2.6
upper = -0.15
rest = -1.6
velocity = 4.0
acceleration = 30.0
effort = 600.0

[[joint]]
name = "wrist_yaw"
type = "revolute"
parent = "forearm"
child = "wrist_1"
axis = [0.0, 0.0, 1.0]
position = [0.0, 0.0, -0.45]
lower = -2.9
upper = 2.9
velocity = 8.0
acceleration = 80.0
effort = 72.0

[[joint]]
name = "wrist_pitch"
type = "revolute"
parent = "wrist_1"
child = "wrist_2"
axis = [0.0, 1.0, 0.0]
lower = -1.35
upper = 1.35
velocity = 8.0
acceleration = 80.0
effort = 72.0

[[joint]]
name = "wrist_roll"
type = "revolute"
parent = "wrist_2"
child = "wrist_3"
axis = [1.0, 0.0, 0.0]
lower = -2.9
upper = 2.9
velocity = 8.0
acceleration = 80.0
effort = 72.0

[[joint]]
name = "grip"
type = "fixed"
parent = "wrist_3"
child = "handle"
position = [0.0, 0.0, -0.15]
orientation = [0.9210609940028851, 0.0, 0.3894183423086505, 0.0]  # upright where the joints are at rest
)";
}

}  // namespace palpate

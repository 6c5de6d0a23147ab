#!/usr/bin/env python3
"""Stands in for the ROS driver of a haptic device: speaks CRTK for a handle that moves up and down by itself.
usage: driver.py [PREFIX [X Y Z]], the lowest point of the handle, m. Prints the largest wrench of each second."""

import math
import sys

import rospy
from geometry_msgs.msg import PoseStamped, WrenchStamped
from std_msgs.msg import Header

SWING = 0.03  # m, from the middle to either end
SPEED = 3.0  # rad/s


def main():
    arguments = rospy.myargv(sys.argv)[1:]
    prefix = arguments[0] if arguments else "/omni"
    x, y, z = (float(a) for a in arguments[1:4]) if len(arguments) > 3 else (0.25, 0.0, 0.03)
    rospy.init_node("driver")
    pose_topic = rospy.Publisher(prefix + "/measured_cp", PoseStamped, queue_size=4, tcp_nodelay=True)
    echo_topic = rospy.Publisher(prefix + "/palpate/echoed", Header, queue_size=4, tcp_nodelay=True)
    largest = [0.0]

    def feel(message):
        force = message.wrench.force  # to the motors
        largest[0] = max(largest[0], math.sqrt(force.x**2 + force.y**2 + force.z**2))

    def answer(echo):
        """Palpate finds out by this how long messages take, and how far the clocks are apart."""
        echo_topic.publish(Header(seq=echo.seq, stamp=rospy.Time.now(), frame_id=""))

    rospy.Subscriber(prefix + "/spatial/servo_cf", WrenchStamped, feel, tcp_nodelay=True)
    rospy.Subscriber(prefix + "/palpate/echo", Header, answer, tcp_nodelay=True)

    def tell(_):
        print(f"up to {largest[0]:.2f} N", flush=True)
        largest[0] = 0.0

    rospy.Timer(rospy.Duration(1.0), tell)
    message = PoseStamped()
    message.header.frame_id = "base"
    message.pose.orientation.w = 1.0
    rate = rospy.Rate(1000)
    while not rospy.is_shutdown():
        message.header.stamp = rospy.Time.now()
        angle = SPEED * message.header.stamp.to_sec()
        message.pose.position.x, message.pose.position.y = x, y
        message.pose.position.z = z + SWING * (1.0 + math.cos(angle))
        pose_topic.publish(message)
        rate.sleep()


if __name__ == "__main__":
    try:
        main()
    except rospy.ROSInterruptException:
        pass

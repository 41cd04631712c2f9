// The part of a message of ROS 2 that a node of an export uses.
#pragma once
#include <vector>

namespace std_msgs::msg {
struct Float64MultiArray {
    std::vector<double> data;
};
}

// The part of rclcpp that a node of an export uses, with the time of clock.h. The node gets columns on every topic it
// subscribes to, as long as OUTPUTS and INPUTS say; one of another length on y first.
#pragma once
#include <cstdio>
#include <functional>
#include <map>
#include <memory>
#include <string>

#include "../clock.h"
#include <std_msgs/msg/float64_multi_array.hpp>

#define RCLCPP_WARN(logger, ...) (void)(logger), std::printf(__VA_ARGS__), std::printf("\n")

namespace rclcpp {
using Message = std_msgs::msg::Float64MultiArray;

inline std::map<std::string, std::function<void(const Message &)>> &topics()
{
    static std::map<std::string, std::function<void(const Message &)>> all;
    return all;
}

template <class M> struct Publisher {
    using SharedPtr = std::shared_ptr<Publisher<M>>;
    std::string topic;
    void publish(const M &message)
    {
        std::printf("%s", topic.c_str());
        for (double x : message.data) {
            std::printf(" %.17g", x);
        }
        std::printf("\n");
    }
};

template <class M> struct Subscription {
    using SharedPtr = std::shared_ptr<Subscription<M>>;
};

struct Duration {
    int64_t nanoseconds;
    double seconds() const { return static_cast<double>(nanoseconds) / 1e9; }
};

struct Time {
    int64_t nanoseconds = 0;
    Duration operator-(const Time &other) const { return {nanoseconds - other.nanoseconds}; }
};

class Node {
public:
    Time now() const { return {1000 * clock_us}; }
    explicit Node(const std::string &name) { std::printf("%s\n", name.c_str()); }
    int get_logger() { return 0; }
    template <class M> typename Publisher<M>::SharedPtr create_publisher(const std::string &topic, int)
    {
        return std::make_shared<Publisher<M>>(Publisher<M>{topic});
    }
    template <class M, class F> typename Subscription<M>::SharedPtr create_subscription(const std::string &topic, int, F call)
    {
        topics()[topic] = call;
        return std::make_shared<Subscription<M>>();
    }
};

inline void init(int, char **) {}
inline void shutdown() {}

inline void spin(std::shared_ptr<Node>)
{
    topics()["y"](Message{std::vector<double>(OUTPUTS + 1)});
    auto given = [] {
        for (auto &[topic, call] : topics()) {
            if (topic != "y") {
                call(Message{std::vector<double>(INPUTS, input())});
            }
        }
    };
    for (int k = 0; k < STEPS; ++k) {
        const int64_t time = (k + 1) * int64_t{PERIOD} + late(k);
        clock_us = time;
#if !IS_VARYING
        given();
#endif
        topics()["y"](Message{std::vector<double>(OUTPUTS, measured())});
#if IS_VARYING
        // At the sample and between samples.
        given();
        clock_us = time + PERIOD / 3;
        given();
#endif
    }
}
}

// What the header of C++ gives beyond the loop of many_props.cpp: stress, reactions, the flight of a free body. Takes the
// golden files of each.
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "vademecum.hpp"

using namespace vademecum;

static void check(bool holds, const char *what) {
    if (!holds) {
        std::fprintf(stderr, "%s\n", what);
        std::exit(1);
    }
}

template <typename Call> static void refused(Call call, const char *words) {
    try {
        call();
    } catch (const Error &error) {
        check(std::string(error.what()).find(words) != std::string::npos, error.what());
        return;
    }
    check(false, words);
}

static Body pushed(const char *path) {
    Body body(File::read(path));
    body.push(body.at_node(body.needs().load_nodes - 1), {1, -2, -20});
    body.step();
    return body;
}

static void stress(Body body) {
    check(body.stress_points() > 0 && body.stress_point(0)[0] < body.needs().nodes, "stress points");
    const Tensor s = body.stress(0), e = body.strain(0);
    const double apart = std::pow(s[0] - s[1], 2) + std::pow(s[1] - s[2], 2) + std::pow(s[2] - s[0], 2);
    const double shear = s[3] * s[3] + s[4] * s[4] + s[5] * s[5];
    const double expected = std::sqrt(0.5 * apart + 3 * shear);
    check(expected > 0 && std::fabs(body.von_mises(0) - expected) < 1e-12 * expected, "von Mises");
    check(e[3] * s[3] > 0, "strain");
    refused([&] { body.stress(body.stress_points()); }, "");
    refused([&] { body.stress_point(body.stress_points()); }, "");
    refused([&] { body.throw_({}); }, "supports");
    check(body.read("von_mises")[0] == body.von_mises(0), "a quantity");
}

static void reactions(Body body) {
    const auto exerted = body.reaction(body.find(Named::support, "left"));
    check(exerted[2] != 0, "a reaction");
    refused([&] { body.reaction(99); }, "");
}

static void flight(Body body) {
    body.clear();
    body.rest();
    body.throw_({0, 0, 3}, {5, 1, 0});
    const RigidBody mass = body.rigid_body();
    const double step = body.needs().time_step;
    for (int k = 0; k < 100; k++) {
        body.pull({0, 0, -9.81 * mass.mass});
        const double ahead = body.ahead().position[2];
        check(body.step() && body.motion().position[2] == ahead, "ahead");
    }
    const double time = 100 * step, height = mass.centre[2] + 3 * time - 0.5 * 9.81 * time * time;
    Motion motion = body.motion();
    check(std::fabs(motion.position[2] - height) < 1e-12, "the height of a thrown body");

    // Where a place goes in a short step is its velocity.
    const Place place = body.at_node(0);
    const Vector before = body.in_space(place), speed = body.in_space(place, Field::velocity);
    body.step();
    const Vector after = body.in_space(place);
    for (int k = 0; k < 3; k++) {
        const double rate = (after[k] - before[k]) / step;
        check(std::fabs(rate - speed[k]) < 0.05 * (1 + std::fabs(speed[k])), "the velocity of a place");
    }
    body.push(place, {1, 0, 0});
    body.push_pattern(0, 1);
    body.step();
    check(body.motion().momentum[0] != motion.momentum[0], "a push");
    motion.attitude[0] = std::nan("");
    refused([&] { body.set_motion(motion); }, "finite");
}

int main(int count, char **paths) {
    check(count == 4, "the golden files stress, reactions and free");
    stress(pushed(paths[1]));
    reactions(pushed(paths[2]));
    flight(pushed(paths[3]));
    return 0;
}

// A hundred bodies of one file, a live parameter where the file has one, and a refusal, in C++17.
//
//   c++ -std=c++17 -O2 many_props.cpp -I ../include ../../../target/release/libvademecum.a -lm -lpthread -ldl -o many_props
//   ./many_props beam.vdm
#include <cstdio>
#include <vector>

#include "vademecum.hpp"

int main(int count, char **arguments) try {
    if (count != 2) {
        std::fprintf(stderr, "usage: %s FILE.vdm\n", arguments[0]);
        return 2;
    }
    const vademecum::File file = vademecum::File::read(arguments[1]);
    file.verify();
    vademecum::Body body(file);
    const vademecum::Place finger = body.locate({0.9, 0.05, 0.1});

    // Each prop is pushed a little harder than the one before.
    vademecum::Batch props(body, 100);
    for (std::size_t prop = 0; prop < props.size(); prop++) {
        body.clear();
        body.push(finger, {0.0, 0.0, -0.1 * static_cast<double>(prop)});
        props.load(prop);
    }
    const VdmBatchStatus found = props.step(250);

    // One of them, read through the body, as a picture wants it.
    props.get(99);
    std::vector<float> vertices(3 * std::size_t{body.needs().surface_nodes});
    body.surface(vademecum::Field::displacement, vertices.data(), vertices.size());
    const std::uint32_t tip = body.find(vademecum::Named::probe, "tip");
    std::printf("%zu props move, tip of the last %.17e, first vertex %g\n", found.moving, body.probe(tip),
                static_cast<double>(vertices[0]));

    // The same alone: the same bits.
    vademecum::Body alone(file);
    alone.push(finger, {0.0, 0.0, -0.1 * 99.0});
    alone.step(250);
    if (alone.probe(tip, vademecum::Field::velocity) != body.probe(tip, vademecum::Field::velocity)) return 3;
    try {
        body.find(vademecum::Named::pattern, "wind");
    } catch (const vademecum::Error &error) {
        std::printf("refused: %s\n", error.what());
    }
    return 0;
} catch (const vademecum::Error &error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
}

// Prints the path of a hand in metres, ten positions per second:
//
//     path_of_a_hand walk.bvh LeftHand

#include <cstdio>

#include <mocap.hpp>

int main(int argc, char **argv)
try {
    if (argc != 3) {
        std::fprintf(stderr, "usage: path_of_a_hand FILE JOINT\n");
        return 2;
    }
    const mocap::Scene scene = mocap::Scene::open(argv[1]).converted();
    const std::uint32_t hand = scene.find(argv[2]);
    if (hand == mocap::no_node) {
        throw mocap::Error(mocap_error_text());
    }
    for (double tick = 0; tick <= scene.duration(); tick += scene.ticks_per_second() / 10) {
        const mocap::Matrix place = scene.world(tick)[hand];
        std::printf("%.3f %.3f %.3f\n", place[12], place[13], place[14]);
    }
} catch (const mocap::Error &error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
}

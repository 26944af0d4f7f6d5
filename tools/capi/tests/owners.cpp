// Uses everything in mocap.hpp once, and frees nothing by hand.
//
//     owners lecture_Test.bvh walk.bvh walk.mclip hero.gltf mirrored.bvh

#include <cmath>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <string>
#include <thread>
#include <type_traits>
#include <vector>

#include <mocap.hpp>

using mocap::Matrix;

static_assert(!std::is_copy_constructible<mocap::Scene>::value, "a handle has one owner");
static_assert(std::is_nothrow_move_constructible<mocap::Scene>::value, "and may be handed on");

namespace {

void check(bool holds, const std::string &what)
{
    if (!holds) {
        throw std::runtime_error("it does not hold that " + what);
    }
}

// The message of the error that a call throws.
template <class Call> std::string error_of(Call call)
{
    try {
        call();
    } catch (const mocap::Error &error) {
        return error.what();
    }
    throw std::runtime_error("there is no error");
}

std::string bytes_of(const std::string &path)
{
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

float distance(const std::vector<Matrix> &some, const std::vector<Matrix> &others)
{
    check(some.size() == others.size(), "poses have one length");
    float farthest = 0;
    for (std::size_t node = 0; node < some.size(); node++) {
        for (int axis = 12; axis < 15; axis++) {
            farthest = std::fmax(farthest, std::fabs(some[node][axis] - others[node][axis]));
        }
    }
    return farthest;
}

void lecture(const std::string &path)
{
    const std::string bytes = bytes_of(path);
    mocap::Scene read = mocap::Scene::read(bytes.data(), bytes.size(), path);
    const mocap::Scene scene = std::move(read);
    const std::uint32_t end = scene.find("EndSite_Wrist");
    check(end == 3 && scene.node_count() == 4 && scene.parent(0) == mocap::no_node, "the arm has four nodes");
    check(scene.node_name(0) == "Shoulder" && scene.parent(end) == 2, "they are in order");
    check(scene.channel_count() == 3 && scene.channel_node(1) == 1, "the end site has no channel");
    check(scene.channel_node(9) == mocap::no_node, "nor is there a tenth");
    std::vector<Matrix> world(scene.node_count());
    for (double tick = 0; tick <= scene.duration(); tick += 1) {
        scene.world(tick, world);
        std::printf("%.0f %.3f %.3f %.3f\n", tick, world[end][12], world[end][13], world[end][14]);
    }
    check(distance(scene.world(9), world) == 0, "both calls give one pose");
    const std::vector<mocap_chain_matrix> chain = scene.chain("Wrist", 9);
    check(chain.size() == 5 && chain[4].letter == 'J' && chain[4].index == 2, "the chain is J0 L1 J1 L2 J2");
    const std::array<float, 3> tip = scene.point_to_world("Wrist", {0.5F, 0.0F, 0.0F}, 9);
    check(std::fabs(tip[0] - world[end][12]) < 1e-5F && std::fabs(tip[1] - world[end][13]) < 1e-5F, "its tip is the end");
    check(error_of([&] { scene.chain("Wirst", 9); }).find("no joint is called") != std::string::npos, "names count");
    check(distance(scene.rest_world(), scene.rest_world()) == 0 && scene.rest_local().size() == 4, "there is a rest pose");
}

void errors(const mocap::Scene &scene)
{
    check(error_of([] { mocap::Scene::open("no.bvh"); }).find("no.bvh") != std::string::npos, "the file is named");
    check(error_of([&] { scene.node_name(9999); }).find("there is no node 9999") == 0, "the node is named");
    check(error_of([&] { scene.duration(7); }).find("there is no animation 7") == 0, "the animation is named");
    check(error_of([&] { scene.edited("[\"dance\"]"); }).find("dance") != std::string::npos, "the step is named");
    check(error_of([] { mocap::run("{\"write\": 1}"); }).find("write") != std::string::npos, "the key is named");
    check(error_of([] { mocap::Clip("nothing", 7); }) != "", "no clip is opened");
    std::vector<Matrix> small(1);
    try {
        scene.world(0, small);
        check(false, "there is room for one");
    } catch (const mocap::Error &error) {
        check(error.status() == MOCAP_STATUS_BAD_ARGUMENT, "the argument is at fault");
    }
    check(scene.find("nobody") == mocap::no_node, "nobody is found");
    // A pointer that is kept too long still points to a text, of any failure.
    const char *kept = mocap_error_text();
    const char *of_thread = nullptr;
    std::thread thread([&] {
        mocap_open_file("gone.bvh");
        of_thread = mocap_error_text();
    });
    thread.join();
    mocap_open_file("another.bvh");
    check(std::string(kept).size() < 4096 && std::string(of_thread).size() < 4096, "texts do not dangle");
}

void changes(const mocap::Scene &walk, const std::string &output)
{
    const mocap::Scene metres = walk.converted();
    check(!metres.assumptions().empty(), "the unit was assumed");
    mocap_conversion conversion = mocap_conversion();
    conversion.frame_rate = 30;
    check(walk.converted(conversion).ticks_per_second() == 30, "there are 30 frames a second");
    const mocap::Scene twice = metres.edited("[\"mirror\", \"mirror\"]");
    check(twice.reports().size() == 2, "two steps were done");
    check(distance(twice.world(50), metres.world(50)) < 1e-5F, "a mirror image of a mirror image is the motion");
    const mocap::Scene longer = metres.edited("[\"concat\"]", {&twice});
    check(longer.duration() > 1.9 * metres.duration(), "the second motion follows");
    check(walk.warnings().empty() && walk.animation_count() == 1, "the file is sound");

    const std::string job = "{\"source\": {\"inputs\": [\"../../fixtures/real/cmu_short.bvh\"]}, "
                            "\"steps\": [\"mirror\"], \"write\": {\"output\": \"" +
                            output + "\"}}";
    check(mocap::run(job).find("\"files\"") != std::string::npos, "the job reports its files");
    check(mocap::Scene::open(output).node_count() == walk.node_count(), "and has written one");
    check(mocap::verify("../../fixtures/real/cmu_short.bvh", output).find("\"findings\":[]") != std::string::npos,
          "the output says what was done, and is that");
}

void clip(const mocap::Scene &metres, const std::string &path)
{
    const std::string bytes = bytes_of(path);
    mocap::Clip clip(bytes.data(), bytes.size());
    check(clip.node_count() == metres.node_count() && clip.duration() == metres.duration(), "it is the walk");
    check(clip.ticks_per_second() == metres.ticks_per_second(), "at its rate");
    std::vector<Matrix> local(clip.node_count()), world(clip.node_count());
    for (double tick = 0; tick < clip.duration(); tick += 20) {
        clip.pose(tick, local, world);
        check(distance(world, metres.world(tick)) < 0.001F, "every joint is within a millimetre");
        check(distance(world, clip.world(tick)) == 0, "both calls give one pose");
    }
}

void retargeter(const mocap::Scene &walk, const mocap::Scene &hero)
{
    mocap::Retargeter retargeter(walk, hero);
    const std::vector<Matrix> source = walk.local(50);
    std::vector<Matrix> local(hero.node_count()), world(hero.node_count());
    retargeter.pose(source, local, world);
    check(distance(world, retargeter.world(source)) == 0, "both calls give one pose");
    check(distance(world, hero.rest_world()) > 0.1F, "the hero moves");
    check(!retargeter.unmapped().empty(), "some bones are not moved");
    const std::vector<Matrix> none;
    check(error_of([&] { retargeter.world(none); }) != "", "a pose is needed");
}

} // namespace

void controller(const mocap::Scene &walk, const mocap::Scene &hero)
{
    mocap::Controller figure(hero, {walk.get()}, true);
    for (int frame = 0; frame < 120; frame++) {
        figure.steer(0, 1.2f);
    }
    const std::array<float, 4> root = figure.root();
    check(root[1] > 0.5f && std::fabs(std::hypot(root[2], root[3]) - 1) < 1e-4f, "a figure goes where it is asked to");
    figure.follow({{root[0], root[1], root[0], root[1], root[0], root[1], 0, 1, 0, 1, 0, 1}});
    check(figure.world().size() == hero.node_count(), "a figure has the nodes of its character");
    check(error_of([&] { mocap::Controller::open(hero, "nothing", 7); }) != "", "no database is opened");
}

void robot_stream(const mocap::Scene &walk, const std::string &robot)
{
    mocap::RobotStream stream(walk, robot, 30, 1);
    check(std::fabs(stream.delay() - 0.1) < 1e-9, "one pass is a tenth of a second late");
    check(stream.joint_names().size() == 19 && stream.report() == "null", "the robot has its joints");
    std::size_t frames = 0;
    for (int tick = 0; tick < 6; tick++) {
        frames += stream.push(walk.local(tick)).empty() ? 0 : 1;
    }
    check(frames == 3, "a frame comes when its time has come");
    for (std::vector<double> frame = stream.pull(); !frame.empty(); frame = stream.pull()) {
        check(frame.size() == 7 + 19 && frame[2] > 0.5, "the robot stands");
        frames++;
    }
    check(frames == 6 && stream.report().find("\"frames\":6") != std::string::npos, "no frame is lost");
    check(error_of([&] { stream.push(walk.local(0)); }) != "", "nothing comes after the end");
    check(error_of([&] { mocap::RobotStream(walk, robot, 0); }).find("from 1 to 1000") != std::string::npos, "a rate");
    check(error_of([&] { mocap::RobotStream(walk, "none.urdf", 30); }) != "", "no robot");
}

void tables(const mocap::Scene &walk)
{
    const mocap::Table angles(walk, "angles");
    check(angles.column_count() > 10 && angles.row_count() == 75 && angles.rate() > 1, "a walk has angles");
    check(angles.values().size() == angles.column_count() * angles.row_count(), "each column has a value in each row");
    check(angles.unit(0) == "deg" || angles.unit(0) == "m", "a column has a unit");
    check(error_of([&] { angles.name(angles.column_count()); }) != "", "there is no column beyond the last");
    check(error_of([&] { mocap::Table(walk, "forces"); }) != "", "a BVH has no force plates");
    check(walk.report("gait").find("strides") != std::string::npos, "a walk has strides");
    check(walk.report("solved") == "null", "no markers were solved");
}

int main(int argc, char **argv)
try {
    check(argc == 7, "there are six files");
    mocap::check_interface();
    lecture(argv[1]);
    const mocap::Scene walk = mocap::Scene::open(argv[2]);
    errors(walk);
    tables(walk);
    check(mocap::Scene::open_as(argv[2], "{}").node_count() == walk.node_count(), "no options are needed");
    changes(walk, argv[5]);
    clip(walk.converted(), argv[3]);
    retargeter(walk, mocap::Scene::open(argv[4]));
    controller(walk, mocap::Scene::open(argv[4]));
    robot_stream(walk, argv[6]);
    check(mocap::version() == mocap_version(), "there is one version");
    std::printf("all is as it should be\n");
} catch (const std::exception &error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
}

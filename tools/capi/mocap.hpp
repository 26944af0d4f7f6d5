// The C++ interface of mocap, for C++11 and later. Objects own the handles of mocap.h, and errors are exceptions.
//
//     mocap::Scene walk = mocap::Scene::open("walk.bvh").converted();
//     std::vector<mocap::Matrix> matrices = walk.world(30.5);
//
// mocap.h describes each function. Objects free their memory by themselves. They can be moved, but not copied. A
// `mocap::Scene` never changes, so any number of threads may use it at the same time. Only one thread at a time may use
// a `mocap::Clip`, a `mocap::Retargeter` or a `mocap::RobotStream`.

#ifndef MOCAP_HPP
#define MOCAP_HPP

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "mocap.h"

namespace mocap {

/// A failed call: `what()` is a copy of `mocap_error_text()`, and lives as long as the exception.
class Error : public std::runtime_error {
public:
    explicit Error(const std::string &text, mocap_status status = MOCAP_STATUS_READ_FAILED)
        : std::runtime_error(text), status_(status)
    {
    }

    mocap_status status() const noexcept { return status_; }

private:
    mocap_status status_;
};

/// A matrix from a node to its parent or to the world, in column-major order, for column vectors.
using Matrix = std::array<float, 16>;

/// The index for no node: the parent of the root, and the result of a search without a match.
constexpr std::uint32_t no_node = MOCAP_NO_NODE;

namespace detail {

// Code below treats an array of matrices as one block of floats.
static_assert(sizeof(Matrix) == 16 * sizeof(float), "a matrix is sixteen floats");

inline void check(mocap_status status)
{
    if (status != MOCAP_STATUS_OK) {
        throw Error(mocap_error_text(), status);
    }
}

/// Returns the value of a call, or throws `Error` if there is an error text.
template <class Value> Value checked(Value value)
{
    const char *text = mocap_error_text();
    if (*text != '\0') {
        throw Error(text);
    }
    return value;
}

template <class Handle> Handle *opened(Handle *handle)
{
    if (handle == nullptr) {
        throw Error(mocap_error_text());
    }
    return handle;
}

inline float *floats(std::vector<Matrix> &matrices)
{
    return matrices.empty() ? nullptr : matrices.front().data();
}

struct Close {
    void operator()(mocap_scene *scene) const noexcept { mocap_close(scene); }
    void operator()(mocap_clip *clip) const noexcept { mocap_clip_close(clip); }
    void operator()(mocap_retargeter *retargeter) const noexcept { mocap_retargeter_free(retargeter); }
    void operator()(mocap_controller *controller) const noexcept { mocap_controller_free(controller); }
    void operator()(mocap_robot_stream *stream) const noexcept { mocap_robot_stream_free(stream); }
    void operator()(mocap_table *table) const noexcept { mocap_table_free(table); }
    void operator()(char *text) const noexcept { mocap_text_free(text); }
};

} // namespace detail

/// An open motion file.
class Scene {
public:
    /// Reads a file. Throws `Error` with file, line and column if reading fails.
    static Scene open(const std::string &path) { return Scene(detail::opened(mocap_open_file(path.c_str()))); }

    /// Reads a file with the options of a job. `reading` is the JSON of the job's `read`, such as `{"markers":
    /// "auto"}`.
    static Scene open_as(const std::string &path, const std::string &reading)
    {
        return Scene(detail::opened(mocap_open_file_as(path.c_str(), reading.c_str())));
    }

    /// Reads the bytes of a file, and does not keep them. `name` is the file name in errors.
    static Scene read(const void *bytes, std::size_t size, const std::string &name)
    {
        return Scene(detail::opened(mocap_open_memory(static_cast<const std::uint8_t *>(bytes), size, name.c_str())));
    }

    /// Returns a copy in metres with +Y up, as `mocap convert` does.
    Scene converted(const mocap_conversion &conversion = mocap_conversion()) const
    {
        return Scene(detail::opened(mocap_convert(get(), &conversion)));
    }

    /// Returns an edited copy. `steps` is a JSON list of steps, as for `mocap_edit`. `others` are the second motions of
    /// the steps that take one, in order.
    Scene edited(const std::string &steps, const std::vector<const Scene *> &others = {}) const
    {
        std::vector<const mocap_scene *> handles;
        for (const Scene *other : others) {
            handles.push_back(other->get());
        }
        const std::size_t count = handles.size();
        return Scene(detail::opened(mocap_edit(get(), steps.c_str(), count == 0 ? nullptr : handles.data(), count)));
    }

    std::uint32_t node_count() const { return detail::checked(mocap_node_count(get())); }

    std::string node_name(std::uint32_t node) const { return detail::checked(mocap_node_name(get(), node)); }

    /// The parent of a node; `no_node` for the root.
    std::uint32_t parent(std::uint32_t node) const { return detail::checked(mocap_node_parent(get(), node)); }

    /// The first node with this name; `no_node` if there is none.
    std::uint32_t find(const std::string &name) const noexcept { return mocap_find_node(get(), name.c_str()); }

    std::uint32_t animation_count() const { return detail::checked(mocap_animation_count(get())); }

    /// The length of an animation in ticks.
    double duration(std::uint32_t animation = 0) const { return detail::checked(mocap_duration(get(), animation)); }

    double ticks_per_second(std::uint32_t animation = 0) const
    {
        return detail::checked(mocap_ticks_per_second(get(), animation));
    }

    /// The number of channels of an animation, one for each node that it moves.
    std::size_t channel_count(std::uint32_t animation = 0) const
    {
        return detail::checked(mocap_channel_count(get(), animation));
    }

    /// The node that a channel moves; `no_node` if it moves none, or there is no such channel.
    std::uint32_t channel_node(std::size_t channel, std::uint32_t animation = 0) const noexcept
    {
        return mocap_channel_node(get(), animation, channel);
    }

    /// The matrix of every node relative to its parent at a tick.
    std::vector<Matrix> local(double tick, std::uint32_t animation = 0) const
    {
        std::vector<Matrix> matrices(node_count());
        local(tick, matrices, animation);
        return matrices;
    }

    /// Writes the matrices into an existing vector of at least `node_count()` matrices, without allocation.
    void local(double tick, std::vector<Matrix> &matrices, std::uint32_t animation = 0) const
    {
        detail::check(mocap_local_matrices(get(), animation, tick, detail::floats(matrices), matrices.size()));
    }

    /// The matrix of every node relative to the world at a tick.
    std::vector<Matrix> world(double tick, std::uint32_t animation = 0) const
    {
        std::vector<Matrix> matrices(node_count());
        world(tick, matrices, animation);
        return matrices;
    }

    /// Writes the matrices into an existing vector of at least `node_count()` matrices, without allocation.
    void world(double tick, std::vector<Matrix> &matrices, std::uint32_t animation = 0) const
    {
        detail::check(mocap_world_matrices(get(), animation, tick, detail::floats(matrices), matrices.size()));
    }

    /// The matrix of every node relative to its parent in the rest pose.
    std::vector<Matrix> rest_local() const
    {
        std::vector<Matrix> matrices(node_count());
        detail::check(mocap_rest_local_matrices(get(), detail::floats(matrices), matrices.size()));
        return matrices;
    }

    /// The matrix of every node relative to the world in the rest pose.
    std::vector<Matrix> rest_world() const
    {
        std::vector<Matrix> matrices(node_count());
        detail::check(mocap_rest_world_matrices(get(), detail::floats(matrices), matrices.size()));
        return matrices;
    }

    /// The matrices J0, L1, J1, ... from the root to a joint at a tick, each with the product up to this matrix.
    std::vector<mocap_chain_matrix> chain(const std::string &joint, double tick, std::uint32_t animation = 0) const
    {
        std::vector<mocap_chain_matrix> matrices(2 * std::size_t(node_count()));
        matrices.resize(detail::checked(mocap_chain(
            get(), animation, tick, joint.c_str(), nullptr, nullptr, matrices.data(), matrices.size())));
        return matrices;
    }

    /// The world position of a point in a joint's coordinate frame at a tick.
    std::array<float, 3> point_to_world(
        const std::string &joint, std::array<float, 3> point, double tick, std::uint32_t animation = 0) const
    {
        std::array<float, 3> world{};
        detail::checked(
            mocap_chain(get(), animation, tick, joint.c_str(), point.data(), world.data(), nullptr, 0));
        return world;
    }

    /// The warnings of the reader.
    std::vector<std::string> warnings() const
    {
        return texts(mocap_warning_count(get()), mocap_warning_text);
    }

    /// The assumptions that the file does not state, with reasons.
    std::vector<std::string> assumptions() const
    {
        return texts(mocap_assumption_count(get()), mocap_assumption_text);
    }

    /// The changes of each step that `edited` applied.
    std::vector<std::string> reports() const
    {
        return texts(mocap_edit_report_count(get()), mocap_edit_report_text);
    }

    /// The report "inspect", "bones", "solved", "recorded" or "gait" as JSON; see `mocap_report`.
    std::string report(const std::string &what) const
    {
        const std::unique_ptr<char, detail::Close> json(detail::opened(mocap_report(get(), what.c_str())));
        return json.get();
    }

    /// The handle for the functions of mocap.h. The object still owns the handle.
    const mocap_scene *get() const noexcept { return handle_.get(); }

private:
    explicit Scene(mocap_scene *handle) noexcept : handle_(handle) {}

    std::vector<std::string> texts(std::size_t count, const char *(*text)(const mocap_scene *, std::size_t)) const
    {
        std::vector<std::string> found;
        for (std::size_t index = 0; index < count; index++) {
            found.emplace_back(detail::checked(text(get(), index)));
        }
        return found;
    }

    std::unique_ptr<mocap_scene, detail::Close> handle_;
};

/// A packed clip: decodes poses from the bytes of a `.mclip`.
class Clip {
public:
    /// Opens a copy of the bytes.
    Clip(const void *bytes, std::size_t size)
        : handle_(detail::opened(mocap_clip_open(static_cast<const std::uint8_t *>(bytes), size)))
    {
    }

    std::uint32_t node_count() const { return detail::checked(mocap_clip_node_count(get())); }
    double duration() const { return detail::checked(mocap_clip_duration(get())); }
    double ticks_per_second() const { return detail::checked(mocap_clip_ticks_per_second(get())); }

    /// Writes the matrices at a tick, relative to the parents and to the world, into existing vectors, without
    /// allocation.
    void pose(double tick, std::vector<Matrix> &local, std::vector<Matrix> &world)
    {
        const std::size_t count = local.size() < world.size() ? local.size() : world.size();
        detail::check(mocap_clip_pose(handle_.get(), tick, detail::floats(local), detail::floats(world), count));
    }

    /// The world matrices at a tick.
    std::vector<Matrix> world(double tick)
    {
        std::vector<Matrix> matrices(node_count());
        detail::check(mocap_clip_pose(handle_.get(), tick, nullptr, detail::floats(matrices), matrices.size()));
        return matrices;
    }

    const mocap_clip *get() const noexcept { return handle_.get(); }

private:
    std::unique_ptr<mocap_clip, detail::Close> handle_;
};

/// Retargets poses from one skeleton to another. The scenes may be destroyed first.
class Retargeter {
public:
    /// `scale` is the length of the target's steps relative to the source's steps; 0: the ratio of the leg lengths.
    Retargeter(const Scene &source, const Scene &target, double scale = 0)
        : handle_(detail::opened(mocap_retargeter_new(source.get(), target.get(), scale))),
          target_count_(target.node_count())
    {
    }

    /// Computes the target's matrices, relative to the parents and to the world, from the source's matrices relative to
    /// the parents.
    void pose(const std::vector<Matrix> &source, std::vector<Matrix> &local, std::vector<Matrix> &world)
    {
        const std::size_t count = local.size() < world.size() ? local.size() : world.size();
        put(source, detail::floats(local), detail::floats(world), count);
    }

    /// The target's world matrices.
    std::vector<Matrix> world(const std::vector<Matrix> &source)
    {
        std::vector<Matrix> matrices(target_count_);
        put(source, nullptr, detail::floats(matrices), matrices.size());
        return matrices;
    }

    /// The bones that are not retargeted, with reasons.
    std::vector<std::string> unmapped() const
    {
        std::vector<std::string> found;
        for (std::size_t bone = 0; bone < mocap_unmapped_count(handle_.get()); bone++) {
            found.emplace_back(detail::checked(mocap_unmapped_text(handle_.get(), bone)));
        }
        return found;
    }

    const mocap_retargeter *get() const noexcept { return handle_.get(); }

private:
    void put(const std::vector<Matrix> &source, float *local, float *world, std::size_t count)
    {
        const float *from = source.empty() ? nullptr : source.front().data();
        detail::check(mocap_retarget_pose(handle_.get(), from, source.size(), local, world, count));
    }

    std::unique_ptr<mocap_retargeter, detail::Close> handle_;
    std::uint32_t target_count_;
};

/// Retargets a live motion to a robot. The scene may be destroyed first.
class RobotStream {
public:
    /// `robot` is the path of a URDF or MJCF file, and `fps` the number of poses per second. With two passes, frames
    /// are smooth and have a delay of 0.6 s. With one pass, the delay is 0.1 s.
    RobotStream(const Scene &source, const std::string &robot, double fps, std::uint8_t passes = 2)
        : handle_(detail::opened(mocap_robot_stream_new(source.get(), robot.c_str(), fps, passes))),
          size_(7 + mocap_robot_stream_joint_count(handle_.get()))
    {
    }

    /// The delay of a frame in seconds.
    double delay() const noexcept { return mocap_robot_stream_delay(handle_.get()); }

    /// The joints, in the order of a frame.
    std::vector<std::string> joint_names() const
    {
        std::vector<std::string> names;
        for (std::size_t joint = 0; joint + 7 < size_; joint++) {
            names.emplace_back(detail::checked(mocap_robot_stream_joint_name(handle_.get(), joint)));
        }
        return names;
    }

    /// Takes the matrices of a pose relative to the parents. Returns MuJoCo's `qpos` of the finished frame, or an empty
    /// vector.
    std::vector<double> push(const std::vector<Matrix> &source)
    {
        std::vector<double> frame(size_);
        bool given = false;
        const float *from = source.empty() ? nullptr : source.front().data();
        detail::check(mocap_robot_stream_push(handle_.get(), from, source.size(), frame.data(), frame.size(), &given));
        frame.resize(given ? size_ : 0);
        return frame;
    }

    /// Ends the stream. Returns the remaining frames one by one, then an empty vector.
    std::vector<double> pull()
    {
        std::vector<double> frame(size_);
        bool given = false;
        detail::check(mocap_robot_stream_pull(handle_.get(), frame.data(), frame.size(), &given));
        frame.resize(given ? size_ : 0);
        return frame;
    }

    /// The quality of the frames of the last 30 s, as JSON.
    std::string report() const
    {
        const std::unique_ptr<char, detail::Close> text(detail::opened(mocap_robot_stream_report(handle_.get())));
        return text.get();
    }

    const mocap_robot_stream *get() const noexcept { return handle_.get(); }

private:
    std::unique_ptr<mocap_robot_stream, detail::Close> handle_;
    std::size_t size_;
};

/// A figure steered by motion matching. The scenes and the bytes may be destroyed first.
class Controller {
public:
    /// Makes a figure from the bytes of a database that includes the motions, as `mocap index --pack` writes it.
    static Controller open(const Scene &character, const void *database, std::size_t size)
    {
        const auto *bytes = static_cast<const std::uint8_t *>(database);
        return Controller(detail::opened(mocap_controller_open(character.get(), bytes, size)), character);
    }

    /// Makes a figure from motions on any skeletons. With `mirror`, also uses the mirror image of each motion.
    Controller(const Scene &character, const std::vector<const mocap_scene *> &motions, bool mirror = false)
        : Controller(
              detail::opened(mocap_controller_new(character.get(), motions.data(), motions.size(), mirror)), character)
    {
    }

    /// Advances by 1/60 s with a velocity along x and z. The figure faces `look`, or the direction of its velocity if
    /// `look` is zero.
    void steer(float x, float z, float look_x = 0, float look_z = 0)
    {
        detail::check(mocap_controller_steer(handle_.get(), x, z, look_x, look_z));
    }

    /// Advances by 1/60 s. `trajectory` has x and z of the wanted positions in 20, 40 and 60 frames, then x and z of
    /// the wanted facings.
    void follow(const std::array<float, 12> &trajectory)
    {
        detail::check(mocap_controller_follow(handle_.get(), trajectory.data()));
    }

    /// The figure's position (x and z), and its facing (x and z).
    std::array<float, 4> root() const
    {
        std::array<float, 4> root{};
        detail::check(mocap_controller_pose(handle_.get(), nullptr, nullptr, 0, root.data()));
        return root;
    }

    /// The world matrices of the character's nodes.
    std::vector<Matrix> world() const
    {
        std::vector<Matrix> matrices(count_);
        detail::check(
            mocap_controller_pose(handle_.get(), nullptr, detail::floats(matrices), matrices.size(), nullptr));
        return matrices;
    }

    const mocap_controller *get() const noexcept { return handle_.get(); }

private:
    Controller(mocap_controller *handle, const Scene &character) : handle_(handle), count_(character.node_count()) {}

    std::unique_ptr<mocap_controller, detail::Close> handle_;
    std::uint32_t count_;
};

/// A table over time of a scene: "angles", "forces" or "analog"; see `mocap_table_new`.
class Table {
public:
    Table(const Scene &scene, const std::string &what)
        : handle_(detail::opened(mocap_table_new(scene.get(), what.c_str())))
    {
    }

    std::size_t column_count() const noexcept { return mocap_table_column_count(handle_.get()); }
    std::size_t row_count() const noexcept { return mocap_table_row_count(handle_.get()); }

    /// Rows per second.
    double rate() const noexcept { return mocap_table_rate(handle_.get()); }

    /// The name of a column. Throws beyond the last.
    std::string name(std::size_t column) const { return text(mocap_table_name(handle_.get(), column)); }

    /// The unit of a column; empty if the file states none. Throws beyond the last.
    std::string unit(std::size_t column) const { return text(mocap_table_unit(handle_.get(), column)); }

    /// All values, row by row, with one value for each column.
    std::vector<double> values() const
    {
        const double *first = mocap_table_values(handle_.get());
        return std::vector<double>(first, first + row_count() * column_count());
    }

private:
    static std::string text(const char *found)
    {
        if (found == nullptr) {
            throw Error("the table has no such column", MOCAP_STATUS_BAD_ARGUMENT);
        }
        return found;
    }

    std::unique_ptr<mocap_table, detail::Close> handle_;
};

/// Runs a job given as JSON, as `mocap run` does. Returns the report as JSON.
inline std::string run(const std::string &job)
{
    const std::unique_ptr<char, detail::Close> report(detail::opened(mocap_run(job.c_str())));
    return report.get();
}

/// Compares a written file with its source; see `mocap_verify`. Returns the differences as JSON.
inline std::string verify(const std::string &source, const std::string &output)
{
    const std::unique_ptr<char, detail::Close> report(detail::opened(mocap_verify(source.c_str(), output.c_str())));
    return report.get();
}

/// Scores a motion of a robot against its reference; see `mocap_score`. `body` is the robot of the reference, if a robot
/// moves in it. Returns the report as JSON.
inline std::string score(const std::string &reference, const std::string &motion, const std::string &robot,
                         const std::string &body = {})
{
    char *found = mocap_score(reference.c_str(), motion.c_str(), robot.c_str(), body.empty() ? nullptr : body.c_str());
    const std::unique_ptr<char, detail::Close> report(detail::opened(found));
    return report.get();
}

/// Throws if the loaded library has another interface version than the header of the program.
inline void check_interface()
{
    if (mocap_interface_version() != MOCAP_INTERFACE_VERSION) {
        throw Error("the library has interface " + std::to_string(mocap_interface_version()) + ", the program needs " +
                        std::to_string(MOCAP_INTERFACE_VERSION),
                    MOCAP_STATUS_BAD_ARGUMENT);
    }
}

/// The version of the library, such as "0.1.0".
inline std::string version()
{
    return mocap_version();
}

} // namespace mocap

#endif // MOCAP_HPP

/* The C interface of mocap: open a motion file, read node matrices at a tick,
 * change motions, put poses on another skeleton or a robot, play packed
 * clips, lead a figure by motion matching, make tables of joint angles and
 * forces.
 *
 * Made from src/lib.rs; see README.md. Do not edit.
 */

#ifndef MOCAP_H
#define MOCAP_H

#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

/*
 The version of this interface. It grows when a program that was compiled against an older header may break;
 compare it with `mocap_interface_version`.
 */
#define MOCAP_INTERFACE_VERSION 1

/*
 The index that stands for no node: the parent of the root, and the answer where nothing is found.
 */
#define MOCAP_NO_NODE 4294967295

/*
 The axis that points up in the file: not known; see `mocap_conversion`.
 */
#define MOCAP_UP_AUTO 0

/*
 The axis that points up in the file: +Y.
 */
#define MOCAP_UP_Y 1

/*
 The axis that points up in the file: +Z.
 */
#define MOCAP_UP_Z 2

/*
 The axis that points up in the file: -Y.
 */
#define MOCAP_UP_NEG_Y 3

/*
 The axis that points up in the file: -Z.
 */
#define MOCAP_UP_NEG_Z 4

/*
 Whether a call did what it was asked for.
 */
typedef enum mocap_status {
  /*
   It did.
   */
  MOCAP_STATUS_OK = 0,
  /*
   An argument is NULL, out of range, or too small.
   */
  MOCAP_STATUS_BAD_ARGUMENT = 1,
  /*
   The file cannot be read.
   */
  MOCAP_STATUS_READ_FAILED = 2,
  /*
   A defect of the library; please report it.
   */
  MOCAP_STATUS_DEFECT = 3,
} mocap_status;

/*
 An open packed clip. Only pointers to it leave the library.
 */
typedef struct mocap_clip mocap_clip;

/*
 A figure that follows what it is asked for by jumps between the frames of motions. Only pointers to it leave the
 library.
 */
typedef struct mocap_controller mocap_controller;

/*
 Moves poses of one skeleton onto another. Only pointers to it leave the library.
 */
typedef struct mocap_retargeter mocap_retargeter;

/*
 Poses in, frames of a robot out. Only pointers to it leave the library.
 */
typedef struct mocap_robot_stream mocap_robot_stream;

/*
 An open motion file. Only pointers to it leave the library.
 */
typedef struct mocap_scene mocap_scene;

/*
 Columns over time. Only pointers to it leave the library.
 */
typedef struct mocap_table mocap_table;

/*
 A matrix of the chain from the root to a joint, T = J0 L1 J1 L2 J2 ..., as a course in animation writes it. A link L
 is the translation of a joint to its parent. A joint J is its rotation, and of the first joint the translation too.
 */
typedef struct mocap_chain_matrix {
  /*
   `J` or `L`.
   */
  char letter;
  /*
   The number behind the letter.
   */
  uint32_t index;
  /*
   The node of the joint or the end site.
   */
  uint32_t node;
  /*
   The matrix, column after column; it maps column vectors.
   */
  float matrix[16];
  /*
   The product of the chain up to this matrix. After the last it is the joint to the world.
   */
  float product[16];
} mocap_chain_matrix;

/*
 What is known about a file, and what is wanted of it. All zero, `mocap_conversion conversion = {0};`, is the
 default.
 */
typedef struct mocap_conversion {
  /*
   Metres in one unit of length of the file. 0: what the file states, else the unit in which the figure has the
   size of a person.
   */
  double metres_per_unit;
  /*
   Frames per second of the result. 0: those of the file.
   */
  double frame_rate;
  /*
   `MOCAP_UP_Y` or another axis. `MOCAP_UP_AUTO`: what the file states, else the axis from the feet to the head.
   */
  uint32_t up;
} mocap_conversion;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/*
 The interface version of the library that the program runs with.
 */
uint32_t mocap_interface_version(void);

/*
 The version of the library, as in "0.1.0". The text is never freed.
 */
const char *mocap_version(void);

/*
 Why the last call of this thread failed, in UTF-8; empty if it did not.

 The text belongs to the thread, and has at most 4,095 bytes. It stays unchanged until the thread's next call that
 fails. A call that succeeds, also one in the same expression, does not change it. Its memory is never freed: a
 pointer that is kept longer shows the text of a later failure, and cannot dangle. Copy the text to keep it. Each
 thread sees its own failures alone.
 */
const char *mocap_error_text(void);

/*
 Frees a scene and every text that came from it. NULL is allowed.

 # Safety
 `scene` comes from `mocap_open_file` or `mocap_open_memory`, was not closed before, and is used by no other thread.
 */
void mocap_close(struct mocap_scene *scene);

/*
 How many things the reader read around. `mocap_warning_text` says what they are.

 # Safety
 `scene` is an open scene.
 */
size_t mocap_warning_count(const struct mocap_scene *scene);

/*
 What the reader read around, from 0 in the order of the file; NULL beyond the last. The text lives as long as the
 scene.

 # Safety
 `scene` is an open scene.
 */
const char *mocap_warning_text(const struct mocap_scene *scene,
                               size_t warning);

/*
 How many nodes the skeleton has, its end sites included. Node 0 is the root; a parent has a smaller index than its
 children.

 # Safety
 `scene` is an open scene.
 */
uint32_t mocap_node_count(const struct mocap_scene *scene);

/*
 The name of a node, in UTF-8; NULL if there is no such node. The text lives as long as the scene.

 # Safety
 `scene` is an open scene.
 */
const char *mocap_node_name(const struct mocap_scene *scene, uint32_t node);

/*
 The parent of a node; MOCAP_NO_NODE for the root, and if there is no such node.

 # Safety
 `scene` is an open scene.
 */
uint32_t mocap_node_parent(const struct mocap_scene *scene, uint32_t node);

/*
 The first node of this name, depth-first; MOCAP_NO_NODE if there is none, and then `mocap_error_text` says so.

 # Safety
 `scene` is an open scene, and `name` is a text that ends with a zero byte.
 */
uint32_t mocap_find_node(const struct mocap_scene *scene,
                         const char *name);

/*
 How many animations the file has; 0 if it is a skeleton alone. BVH has at most one.

 # Safety
 `scene` is an open scene.
 */
uint32_t mocap_animation_count(const struct mocap_scene *scene);

/*
 How many channels an animation has, one for each node that it moves; 0 if there is no such animation.

 # Safety
 `scene` is an open scene.
 */
size_t mocap_channel_count(const struct mocap_scene *scene,
                           uint32_t animation);

/*
 The node that a channel moves. MOCAP_NO_NODE if there is no such channel or animation, and if the channel moves no
 node; then `mocap_error_text` says which.

 # Safety
 `scene` is an open scene.
 */
uint32_t mocap_channel_node(const struct mocap_scene *scene,
                            uint32_t animation,
                            size_t channel);

/*
 The length of an animation in ticks, from the first frame to the last; in BVH a tick is a frame, so this is one
 less than there are frames. 0 if there is no such animation.

 # Safety
 `scene` is an open scene.
 */
double mocap_duration(const struct mocap_scene *scene,
                      uint32_t animation);

/*
 Ticks in a second; 0 if there is no such animation.

 # Safety
 `scene` is an open scene.
 */
double mocap_ticks_per_second(const struct mocap_scene *scene, uint32_t animation);

/*
 Writes the matrix of every node to its parent into `matrices`: 16 floats a node, column after column, as OpenGL and
 Vulkan read them; they map column vectors. `count` is how many matrices there is room for, at least
 `mocap_node_count`. `mocap_open_file` says what unit lengths are in.

 Between two keys the pose is interpolated: positions and scales on a line, rotations on the shorter arc of the
 sphere. Before tick 0 the first pose holds, after the last tick the last; a tick that is NaN stands for 0. With an
 animation that is not there the call fails; a scene without any is asked by `mocap_rest_local_matrices`. Nothing is
 allocated.

 # Safety
 `scene` is an open scene, and `matrices` points to room for 16 x `count` floats.
 */
enum mocap_status mocap_local_matrices(const struct mocap_scene *scene,
                                       uint32_t animation,
                                       double tick,
                                       float *matrices,
                                       size_t count);

/*
 Writes the matrix of every node to the world, that is to the space in which the root stands. Otherwise as
 `mocap_local_matrices`.

 # Safety
 `scene` is an open scene, and `matrices` points to room for 16 x `count` floats.
 */
enum mocap_status mocap_world_matrices(const struct mocap_scene *scene,
                                       uint32_t animation,
                                       double tick,
                                       float *matrices,
                                       size_t count);

/*
 Writes the matrix of every node to its parent in the rest pose, without motion. Otherwise as
 `mocap_local_matrices`.

 # Safety
 `scene` is an open scene, and `matrices` points to room for 16 x `count` floats.
 */
enum mocap_status mocap_rest_local_matrices(const struct mocap_scene *scene,
                                            float *matrices,
                                            size_t count);

/*
 Writes the matrix of every node to the world in the rest pose, without motion. Otherwise as
 `mocap_local_matrices`.

 # Safety
 `scene` is an open scene, and `matrices` points to room for 16 x `count` floats.
 */
enum mocap_status mocap_rest_world_matrices(const struct mocap_scene *scene,
                                            float *matrices,
                                            size_t count);

/*
 Writes the matrices of the chain from the root to `joint`, the name of a node, at `tick`: as many as there are and
 there is room for. Returns how many there are, or 0 where the call fails. With `matrices` NULL and `count` 0 it only
 counts them.

 `point` is three numbers in the space of the joint, or NULL; where it is in the world goes to `point_in_world`. In a
 scene without animations the chain is that of the rest pose. Ticks are as in `mocap_local_matrices`.

 # Safety
 `scene` is an open scene, `joint` a text, and `matrices` points to room for `count` matrices. `point` and
 `point_in_world` are NULL or point to three floats.
 */
size_t mocap_chain(const struct mocap_scene *scene,
                   uint32_t animation,
                   double tick,
                   const char *joint,
                   const float *point,
                   float *point_in_world,
                   struct mocap_chain_matrix *matrices,
                   size_t count);

/*
 Opens a packed clip, the `size` bytes of a file that `mocap convert walk.bvh walk.mclip` wrote. The bytes are
 copied.

 Returns NULL where they are not a whole and valid packed clip; `mocap_error_text` says why. `mocap_clip_close` frees
 it.

 # Safety
 `bytes` points to `size` bytes.
 */
struct mocap_clip *mocap_clip_open(const uint8_t *bytes,
                                   size_t size);

/*
 Frees a packed clip. NULL is allowed.

 # Safety
 `clip` comes from `mocap_clip_open`, was not freed before, and is used by no other thread.
 */
void mocap_clip_close(struct mocap_clip *clip);

/*
 How many nodes a packed clip has, in the order of the file that it was made from; 0 for NULL.

 # Safety
 `clip` is NULL or an open packed clip.
 */
uint32_t mocap_clip_node_count(const struct mocap_clip *clip);

/*
 The last tick of a packed clip; 0 for NULL.

 # Safety
 `clip` is NULL or an open packed clip.
 */
double mocap_clip_duration(const struct mocap_clip *clip);

/*
 Ticks per second of a packed clip; 0 for NULL.

 # Safety
 `clip` is NULL or an open packed clip.
 */
double mocap_clip_ticks_per_second(const struct mocap_clip *clip);

/*
 The pose at `tick`, straight from the packed form: the matrices of all nodes to their parents go to `local`, and to
 the world to `world`; either may be NULL. `count` is how many matrices there is room for, at least
 `mocap_clip_node_count`.

 Nothing is allocated. One thread at a time may use a packed clip.

 # Safety
 `clip` is a packed clip that no other thread uses, and `local` and `world` are NULL or point to room for 16 x
 `count` floats, which do not overlap.
 */
enum mocap_status mocap_clip_pose(struct mocap_clip *clip,
                                  double tick,
                                  float *local,
                                  float *world,
                                  size_t count);

/*
 Makes a figure of the character of a scene, which stands at the origin and looks along +Z. `database` is the `size`
 bytes of a file that `mocap index --pack` wrote, with the motions within.

 The figure is in metres with +Y up, whatever the scene is in; its nodes are those of the scene. It takes memory for
 the pose of every frame of the database, and the scene may be closed then. Returns NULL where the character is no
 humanoid with two legs, and where the bytes are no database; `mocap_error_text` says why. `mocap_controller_free`
 frees it.

 # Safety
 `character` is an open scene, and `database` points to `size` bytes.
 */
struct mocap_controller *mocap_controller_open(const struct mocap_scene *character,
                                               const uint8_t *database,
                                               size_t size);

/*
 Makes a figure as `mocap_controller_open` does, of the motions of `count` scenes, on any skeletons; with `mirror`
 each with left and right exchanged too. The scenes may be closed then.

 # Safety
 `character` is an open scene, and `motions` points to `count` open scenes.
 */
struct mocap_controller *mocap_controller_new(const struct mocap_scene *character,
                                              const struct mocap_scene *const *motions,
                                              size_t count,
                                              bool mirror);

/*
 Frees a figure. NULL is allowed.

 # Safety
 `controller` comes from `mocap_controller_open` or `mocap_controller_new`, was not freed before, and is used by no
 other thread.
 */
void mocap_controller_free(struct mocap_controller *controller);

/*
 Advances by a frame, a sixtieth of a second, by the input of a stick. The input is a velocity over the ground along
 x and z, in metres per second, and a facing (`look_x`, `look_z`). While both are 0, the figure faces its velocity.
 Velocity and direction change smoothly. Seen from behind a figure that looks along +Z, right is along -X.

 Nothing is allocated. One thread at a time may use a figure.

 # Safety
 `controller` is a figure that no other thread uses.
 */
enum mocap_status mocap_controller_steer(struct mocap_controller *controller,
                                         float velocity_x,
                                         float velocity_z,
                                         float look_x,
                                         float look_z);

/*
 Advances by a frame towards a trajectory of 12 floats: x and z in metres of the figure's place in 20, 40 and 60
 frames, then x and z of its facing. Nothing is allocated.

 # Safety
 `controller` is a figure that no other thread uses, and `trajectory` points to 12 floats.
 */
enum mocap_status mocap_controller_follow(struct mocap_controller *controller,
                                          const float *trajectory);

/*
 The pose of a figure: the matrices of all nodes to their parents go to `local`, and to the world to `world`; either
 may be NULL. `count` is how many matrices there is room for, at least `mocap_node_count` of its scene. Place and
 facing of the figure go to the 4 floats of `root`, if that is not NULL. They are x and z in metres, then x and z of
 a direction of length 1. Nothing is allocated.

 # Safety
 `controller` is a figure that no other thread uses. `local` and `world` are NULL or point to room for 16 x `count`
 floats. `root` is NULL or points to room for 4.
 */
enum mocap_status mocap_controller_pose(const struct mocap_controller *controller,
                                        float *local,
                                        float *world,
                                        size_t count,
                                        float *root);

/*
 A copy of a scene in metres with +Y up, as `mocap convert` makes it. `conversion` says what is known about the file;
 NULL stands for the default. `mocap_assumption_text` of the copy says what was guessed.

 Returns NULL where a number of `conversion` has no meaning. The scene that was given stays as it is; each is freed
 by a `mocap_close` of its own. A copy that is converted again stays in metres with +Y up.

 # Safety
 `scene` is an open scene, and `conversion` is NULL or points to a conversion.
 */
struct mocap_scene *mocap_convert(const struct mocap_scene *scene,
                                  const struct mocap_conversion *conversion);

/*
 How many things were assumed about a scene that its file does not say. `mocap_assumption_text` says what they are.

 # Safety
 `scene` is an open scene.
 */
size_t mocap_assumption_count(const struct mocap_scene *scene);

/*
 What was assumed about a scene, from 0, with the reason, as in "unit: cm, because the skeleton measures ...". NULL
 beyond the last. The text lives as long as the scene.

 # Safety
 `scene` is an open scene.
 */
const char *mocap_assumption_text(const struct mocap_scene *scene,
                                  size_t assumption);

/*
 A copy of a scene that steps have changed in their order, as `mocap edit` changes it. `steps` is a JSON list of
 them: each a text as `mocap edit --step` takes it, or an object with its name and its options.

     mocap_edit(walk, "[\"mirror\", {\"step\": \"smooth\", \"cut-off\": 8}]", NULL, 0)

 `others` are the second motions of those steps that take one, in their order, and `other_count` is how many there
 are. Lengths in steps are metres whatever the unit of the scene. The first animation is changed; a rest pose in its
 first frame is changed with it. `mocap_edit_report_text` of the copy says what each step changed.

 Returns NULL where a step is unknown or cannot be done. The scenes that were given stay as they are; each is freed
 by a `mocap_close` of its own.

 # Safety
 `scene` is an open scene, `steps` is a text that ends with a zero byte, and `others` points to `other_count` open
 scenes, or is NULL where `other_count` is 0.
 */
struct mocap_scene *mocap_edit(const struct mocap_scene *scene,
                               const char *steps,
                               const struct mocap_scene *const *others,
                               size_t other_count);

/*
 How many steps `mocap_edit` applied to make a scene. `mocap_edit_report_text` says what they changed.

 # Safety
 `scene` is an open scene.
 */
size_t mocap_edit_report_count(const struct mocap_scene *scene);

/*
 What a step changed, from 0, with units, as in "mirror: 17 pairs of joints exchanged". NULL beyond the last. The
 text lives as long as the scene.

 # Safety
 `scene` is an open scene.
 */
const char *mocap_edit_report_text(const struct mocap_scene *scene,
                                   size_t report);

/*
 Reads a motion file. Returns NULL where that fails; `mocap_error_text` says why, with line and column.

 The formats, told apart by their contents, else by the extension:

 - BVH (`.bvh`) and Acclaim (`.amc` with its `.asf` beside it, or `.asf` alone): lengths in the file's unit.
 - C3D (`.c3d`): markers, each a node; lengths in the file's unit, +Y up.
 - TRC (`.trc`): markers, each a node; lengths in the file's unit, its axes.
 - glTF 2.0 (`.glb`, `.gltf`), VRM animations (`.vrma`) and FBX (`.fbx`): the skeleton and its animations; lengths in
   metres, +Y up.
 - USD (`.usda`, `.usdz`): the skeleton and its animations; lengths in the file's unit, its axes.
 - MikuMikuDance (`.vmd`, `.pmx`): a motion on the model beside it or on generic proportions, a skeleton; lengths
   in units of 0.08 m, +Y up.
 - Packed clips (`.mclip`): the skeleton and its animation; lengths in metres.
 - Arrays of bodies (NumPy's `.npz` and `.npy`, PyTorch's `.pt` and `.pth`, pickles `.pkl` and `.pickle`), in layouts
   that are known by their names or shapes; lengths in metres. Nothing of a file is run.
 - Tables (`.csv`, and `.parquet` in builds with that feature): arrays that this library wrote, and positions.
 - Joint angles of OpenSim (`.mot`, `.sto`): a body of generic proportions; lengths in metres.
 - Robots (URDF `.urdf`, MJCF `.mjcf`): the skeleton alone.

 3ds Max `.bip` is refused, with advice on what to export instead.

 The root's OFFSET of BVH: the root's position channels replace it. They are added to it where the first frame's
 root position is near zero on all axes while the OFFSET is not.

 Any number of threads may use a scene at once; it never changes. `mocap_close` frees it.

 # Safety
 `path` is a text that ends with a zero byte.
 */
struct mocap_scene *mocap_open_file(const char *path);

/*
 Reads a motion file as a job does: `reading` is the JSON of its `read`, which `src/job/job.schema.json` describes.
 So markers are solved into a skeleton, with a trial of somebody who stands:

     mocap_open_file_as("walk.trc", "{\"markers\": \"auto\", \"static\": \"standing.trc\"}")

 `mocap_report` says how well. NULL stands for no options. Otherwise as `mocap_open_file`.

 # Safety
 `path` is a text that ends with a zero byte, and so is `reading`, or it is NULL.
 */
struct mocap_scene *mocap_open_file_as(const char *path,
                                       const char *reading);

/*
 Reads the `size` bytes of a motion file that is in memory already, and does not keep them. `name` stands for the
 file in errors. Otherwise as `mocap_open_file`.

 # Safety
 `bytes` points to `size` bytes, and `name` is a text that ends with a zero byte.
 */
struct mocap_scene *mocap_open_memory(const uint8_t *bytes,
                                      size_t size,
                                      const char *name);

/*
 Prepares the motion of the skeleton of `source` onto that of `target`, both of them humanoids of any rest pose, unit
 and axes. `scale` is how many times as long as those of the source the steps of the target are, in metres; 0: in the
 proportion of the legs.

 Returns NULL where one of the two is not a humanoid; `mocap_error_text` says which and why. The scenes may be closed
 then: the retargeter needs them no more. `mocap_retargeter_free` frees it.

 # Safety
 `source` and `target` are open scenes.
 */
struct mocap_retargeter *mocap_retargeter_new(const struct mocap_scene *source,
                                              const struct mocap_scene *target,
                                              double scale);

/*
 Frees a retargeter and every text that came from it. NULL is allowed.

 # Safety
 `retargeter` comes from `mocap_retargeter_new`, was not freed before, and is used by no other thread.
 */
void mocap_retargeter_free(struct mocap_retargeter *retargeter);

/*
 Puts a pose of the source on the target. `source` has the matrix of every node of the source to its parent, as
 `mocap_local_matrices` writes them, or as they come from a live capture; `source_count` is how many. The matrices of
 the target's nodes go to `local`, to their parents, and to `world`, to the world; either may be NULL. `count` is how
 many matrices there is room for, at least the target's `mocap_node_count`. Nodes that nothing moves keep their rest
 pose.

 Nothing is allocated. One thread at a time may use a retargeter.

 # Safety
 `retargeter` is a retargeter that no other thread uses. `source` points to 16 x `source_count` floats. `local` and
 `world` are NULL or point to room for 16 x `count` floats. They do not overlap with each other or with `source`.
 */
enum mocap_status mocap_retarget_pose(struct mocap_retargeter *retargeter,
                                      const float *source,
                                      size_t source_count,
                                      float *local,
                                      float *world,
                                      size_t count);

/*
 How many bones are not moved from one skeleton to the other. `mocap_unmapped_text` says which and why.

 # Safety
 `retargeter` is a retargeter.
 */
size_t mocap_unmapped_count(const struct mocap_retargeter *retargeter);

/*
 A bone that is not moved, from 0, with the reason, as in "jaw: the target has no such joint"; NULL beyond the last.
 The text lives as long as the retargeter.

 # Safety
 `retargeter` is a retargeter.
 */
const char *mocap_unmapped_text(const struct mocap_retargeter *retargeter,
                                size_t bone);

/*
 Begins a motion on a robot that comes pose by pose, at `fps` poses a second, from 1 to 1000. `source` is the
 skeleton of the poses, a humanoid; an animation of it shows where its floor is. `robot` is the path of a URDF or
 MJCF file. `passes` is 2, for smooth joints and feet that stand, with frames that come 0.6 s later, or 1, with
 0.1 s.

 Returns NULL where the robot cannot be read, and where one of the two is no humanoid; `mocap_error_text` says why.
 The scene may be closed then. `mocap_robot_stream_free` frees it.

 # Safety
 `source` is an open scene, and `robot` is a text that ends with a zero byte.
 */
struct mocap_robot_stream *mocap_robot_stream_new(const struct mocap_scene *source,
                                                  const char *robot,
                                                  double fps,
                                                  uint8_t passes);

/*
 Frees a stream, with the names of its joints. NULL is allowed.

 # Safety
 `stream` comes from `mocap_robot_stream_new`, was not freed before, and is used by no other thread.
 */
void mocap_robot_stream_free(struct mocap_robot_stream *stream);

/*
 How many seconds later a frame is given back; 0 for NULL.

 # Safety
 `stream` is NULL or a stream that lives.
 */
double mocap_robot_stream_delay(const struct mocap_robot_stream *stream);

/*
 How many joints the robot has; a frame has 7 numbers more. 0 for NULL.

 # Safety
 `stream` is NULL or a stream that lives.
 */
size_t mocap_robot_stream_joint_count(const struct mocap_robot_stream *stream);

/*
 The name of a joint, from 0, in the order of a frame; NULL beyond the last. The text lives as long as the stream.

 # Safety
 `stream` is NULL or a stream that lives.
 */
const char *mocap_robot_stream_joint_name(const struct mocap_robot_stream *stream,
                                          size_t joint);

/*
 Takes the next pose: the matrix of every node of the source to its parent, as for `mocap_retarget_pose`. Writes the
 frame whose time has come to `frame`, and whether there is one to `given`. The frame is MuJoCo's `qpos`: x, y and z
 of the base in metres with +Z up, its rotation as w, x, y, z, and the positions of the joints in radians or metres.
 `count` is how many numbers there is room for, at least 7 and one for each joint.

 One thread at a time may use a stream.

 # Safety
 `stream` is a stream that no other thread uses, `source` points to 16 x `source_count` floats, `frame` to room for
 `count` numbers, and `given` to a bool.
 */
enum mocap_status mocap_robot_stream_push(struct mocap_robot_stream *stream,
                                          const float *source,
                                          size_t source_count,
                                          double *frame,
                                          size_t count,
                                          bool *given);

/*
 Ends a stream, and gives the frames that are left, one with each call, until `given` is false: as
 `mocap_robot_stream_push` does.

 # Safety
 `stream` is a stream that no other thread uses, `frame` points to room for `count` numbers, and `given` to a bool.
 */
enum mocap_status mocap_robot_stream_pull(struct mocap_robot_stream *stream,
                                          double *frame,
                                          size_t count,
                                          bool *given);

/*
 How well the frames sit on the robot that were given in the last 30 s, as JSON, with a verdict: the report of
 `mocap robot --json`. "null" before the first. `mocap_text_free` frees it; NULL for NULL.

 # Safety
 `stream` is NULL or a stream that no other thread uses.
 */
char *mocap_robot_stream_report(const struct mocap_robot_stream *stream);

/*
 Does a job, as `mocap run` does: reads files, changes motions, puts them on another body, writes files. `job` is its
 JSON; `src/job/job.schema.json` says what it may hold.

     mocap_run("{\"source\": {\"inputs\": [\"walk.bvh\"]}, \"write\": {\"output\": \"walk.glb\"}}")

 A job with `survey` writes no motion: its report has a row for each clip, in `survey`. One with `graph` writes the
 motion graph of its inputs as JSON, one with `walk` a motion that walks over it; `docs/motion-graphs.md` has both.

 Returns what was done, as JSON with `files`, `notes` and `warnings`, and with `problem` where the output is worse
 than the job allows; `mocap_text_free` frees it. NULL where the job cannot be done; no file is then written.

 # Safety
 `job` is a text that ends with a zero byte.
 */
char *mocap_run(const char *job);

/*
 Compares a written file with the file that it was made of, as `mocap verify` does: what was done between them is
 read from the output, and done again.

 Returns how far they are apart, as JSON with `max_error` in metres and `findings`; `mocap_text_free` frees it. NULL
 where they cannot be compared.

 # Safety
 `source` and `output` are texts that end with a zero byte.
 */
char *mocap_verify(const char *source,
                   const char *output);

/*
 Frees a text that `mocap_run`, `mocap_verify` or `mocap_report` has returned. NULL is allowed.

 # Safety
 `text` comes from one of them, and was not freed before.
 */
void mocap_text_free(char *text);

/*
 Makes a table of a scene, by the name of what is asked for:

 - "angles": the joint angles of a humanoid in degrees, and the position of its pelvis in metres, with the names and
   signs of `docs/biomechanics.md`;
 - "forces": of each force plate of a C3D file, with +Y up: the ground force in newtons, the centre of pressure in
   metres, the free moment in newton metres;
 - "analog": the analog channels of a C3D file, in its units.

 Returns NULL where the scene has nothing of it; `mocap_error_text` says why. `mocap_table_free` frees it. It does
 not need the scene any longer.

 # Safety
 `scene` is an open scene, and `what` is a text that ends with a zero byte.
 */
struct mocap_table *mocap_table_new(const struct mocap_scene *scene,
                                    const char *what);

/*
 Frees a table, its texts and its values. NULL is allowed.

 # Safety
 `table` comes from `mocap_table_new`, was not freed before, and is used by no other thread.
 */
void mocap_table_free(struct mocap_table *table);

/*
 How many columns a table has; 0 for NULL. Time is none of them: row `i` is at `i` divided by `mocap_table_rate`.

 # Safety
 `table` is NULL or comes from `mocap_table_new`.
 */
size_t mocap_table_column_count(const struct mocap_table *table);

/*
 How many rows a table has; 0 for NULL.

 # Safety
 `table` is NULL or comes from `mocap_table_new`.
 */
size_t mocap_table_row_count(const struct mocap_table *table);

/*
 Rows a second; 0 for NULL.

 # Safety
 `table` is NULL or comes from `mocap_table_new`.
 */
double mocap_table_rate(const struct mocap_table *table);

/*
 The name of a column, from 0, such as "knee_angle_r" or "ground_force_1_vy"; NULL beyond the last. The text lives as
 long as the table.

 # Safety
 `table` is NULL or comes from `mocap_table_new`.
 */
const char *mocap_table_name(const struct mocap_table *table,
                             size_t column);

/*
 The unit of a column, such as "deg", "m" or "N"; of analog channels as the file states it, and empty where it does
 not. NULL beyond the last. The text lives as long as the table.

 # Safety
 `table` is NULL or comes from `mocap_table_new`.
 */
const char *mocap_table_unit(const struct mocap_table *table,
                             size_t column);

/*
 The values of a table, row after row, with one for each column; NULL for NULL. They live as long as the table.

 # Safety
 `table` is NULL or comes from `mocap_table_new`.
 */
const double *mocap_table_values(const struct mocap_table *table);

/*
 A report on a scene as JSON, by its name:

 - "solved": how well a skeleton that was solved from markers explains them: `markers`, `rms_of_seconds`, `joints`
   with their lengths and deviations, and `swaps`; `null` for other scenes;
 - "recorded": what a C3D file has beside markers: `events`, `channels` and `plates`; `null` where it has nothing;
 - "inspect": what `mocap info --json` prints: counts, clips, what is assumed, warnings;
 - "bones": which node is which bone of a humanoid, how sure that is, and why;
 - "gait": heel strikes, toe offs and strides of a walk, and the means of a gait laboratory.

 `mocap_text_free` frees it. NULL where there is no such report; `mocap_error_text` says why.

 # Safety
 `scene` is an open scene, and `what` is a text that ends with a zero byte.
 */
char *mocap_report(const struct mocap_scene *scene,
                   const char *what);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* MOCAP_H */

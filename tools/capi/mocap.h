/* The C interface of mocap: open a motion file, read node matrices at a tick,
 * edit motions, retarget poses to another skeleton or a robot, play packed
 * clips, steer a figure by motion matching, make tables of joint angles and
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
 The version of this interface. It increases when a program compiled with an older header may break. Compare it with
 `mocap_interface_version`.
 */
#define MOCAP_INTERFACE_VERSION 1

/*
 The index for no node: the parent of the root, and the result of a search without a match.
 */
#define MOCAP_NO_NODE 4294967295

/*
 The up axis of the file is unknown; see `mocap_conversion`.
 */
#define MOCAP_UP_AUTO 0

/*
 The up axis of the file is +Y.
 */
#define MOCAP_UP_Y 1

/*
 The up axis of the file is +Z.
 */
#define MOCAP_UP_Z 2

/*
 The up axis of the file is -Y.
 */
#define MOCAP_UP_NEG_Y 3

/*
 The up axis of the file is -Z.
 */
#define MOCAP_UP_NEG_Z 4

/*
 The result of a call.
 */
typedef enum mocap_status {
  /*
   The call succeeded.
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
 An open packed clip. Programs only hold pointers to this type.
 */
typedef struct mocap_clip mocap_clip;

/*
 A figure that follows a stick or a trajectory by motion matching. Programs only hold pointers to this type.
 */
typedef struct mocap_controller mocap_controller;

/*
 Retargets poses from one skeleton to another. Programs only hold pointers to this type.
 */
typedef struct mocap_retargeter mocap_retargeter;

/*
 Retargets a stream of poses to a robot. Programs only hold pointers to this type.
 */
typedef struct mocap_robot_stream mocap_robot_stream;

/*
 An open motion file. Programs only hold pointers to this type.
 */
typedef struct mocap_scene mocap_scene;

/*
 A table of columns over time. Programs only hold pointers to this type.
 */
typedef struct mocap_table mocap_table;

/*
 A matrix of the chain from the root to a joint, T = J0 L1 J1 L2 J2 ..., in the notation of animation courses. A link
 L is the translation of a joint relative to its parent. A joint J is the rotation of the joint. J0 also has the
 translation of the root.
 */
typedef struct mocap_chain_matrix {
  /*
   `J` or `L`.
   */
  char letter;
  /*
   The number after the letter.
   */
  uint32_t index;
  /*
   The node of the joint or the end site.
   */
  uint32_t node;
  /*
   The matrix in column-major order; it multiplies column vectors.
   */
  float matrix[16];
  /*
   The product of the chain up to this matrix. The last product maps from the joint to the world.
   */
  float product[16];
} mocap_chain_matrix;

/*
 The known unit and axis of a file, and the wanted frame rate. All zero, `mocap_conversion conversion = {0};`, is the
 default.
 */
typedef struct mocap_conversion {
  /*
   The unit of length of the file, in metres. 0: the unit that the file states, or else the unit in which the
   figure has the size of a person.
   */
  double metres_per_unit;
  /*
   Frames per second of the result. 0: the frame rate of the file.
   */
  double frame_rate;
  /*
   `MOCAP_UP_Y` or another axis. `MOCAP_UP_AUTO`: the axis that the file states, or else the axis from the feet to
   the head.
   */
  uint32_t up;
} mocap_conversion;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/*
 The interface version of the loaded library.
 */
uint32_t mocap_interface_version(void);

/*
 The version of the library, such as "0.1.0". The text is never freed.
 */
const char *mocap_version(void);

/*
 The reason why the last call of this thread failed, in UTF-8; empty if it succeeded.

 The text belongs to the thread, and has at most 4,095 bytes. It stays unchanged until the thread's next failed call.
 Successful calls do not change it, even in the same expression. The memory is never freed, so an old pointer never
 dangles, but it shows the text of a later failure. Copy the text to keep it. Each thread only sees its own failures.
 */
const char *mocap_error_text(void);

/*
 Frees a scene and every text that came from it. NULL is allowed.

 # Safety
 `scene` was returned by a function of this library, was not closed before, and is used by no other thread.
 */
void mocap_close(struct mocap_scene *scene);

/*
 The number of warnings of the reader. `mocap_warning_text` returns each of them.

 # Safety
 `scene` is an open scene.
 */
size_t mocap_warning_count(const struct mocap_scene *scene);

/*
 A warning of the reader, counted from 0 in the order of the file; NULL beyond the last. The text lives as long as
 the scene.

 # Safety
 `scene` is an open scene.
 */
const char *mocap_warning_text(const struct mocap_scene *scene,
                               size_t warning);

/*
 The number of nodes of the skeleton, including end sites. Node 0 is the root. A parent has a smaller index than its
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
 The first node with this name, depth-first. MOCAP_NO_NODE if there is none; `mocap_error_text` then names the node.

 # Safety
 `scene` is an open scene, and `name` is a string that ends with a zero byte.
 */
uint32_t mocap_find_node(const struct mocap_scene *scene,
                         const char *name);

/*
 The number of animations of the file; 0 if the file has only a skeleton. BVH has at most one.

 # Safety
 `scene` is an open scene.
 */
uint32_t mocap_animation_count(const struct mocap_scene *scene);

/*
 The number of channels of an animation, one for each node that it moves; 0 if there is no such animation.

 # Safety
 `scene` is an open scene.
 */
size_t mocap_channel_count(const struct mocap_scene *scene,
                           uint32_t animation);

/*
 The node that a channel moves. MOCAP_NO_NODE if there is no such channel or animation, or if the channel moves no
 node; `mocap_error_text` then has the reason.

 # Safety
 `scene` is an open scene.
 */
uint32_t mocap_channel_node(const struct mocap_scene *scene,
                            uint32_t animation,
                            size_t channel);

/*
 The duration of an animation in ticks, from the first frame to the last. In BVH a tick is a frame, so the duration
 is the number of frames minus 1. 0 if there is no such animation.

 # Safety
 `scene` is an open scene.
 */
double mocap_duration(const struct mocap_scene *scene,
                      uint32_t animation);

/*
 Ticks per second; 0 if there is no such animation.

 # Safety
 `scene` is an open scene.
 */
double mocap_ticks_per_second(const struct mocap_scene *scene, uint32_t animation);

/*
 Writes the matrix of every node relative to its parent into `matrices`. Each matrix has 16 floats in column-major
 order, as in OpenGL and Vulkan, and multiplies column vectors. `count` is the number of matrices that fit in
 `matrices`, at least `mocap_node_count`. Lengths are in the unit of the scene; see `mocap_open_file`.

 The pose between two keys is interpolated: positions and scales linearly, rotations along the shorter arc (slerp).
 Ticks before 0 give the first pose, ticks after the end the last pose, and NaN gives tick 0. The call fails if there
 is no such animation. For a scene without animations, call `mocap_rest_local_matrices`. The call allocates no
 memory.

 # Safety
 `scene` is an open scene, and `matrices` points to room for 16 x `count` floats.
 */
enum mocap_status mocap_local_matrices(const struct mocap_scene *scene,
                                       uint32_t animation,
                                       double tick,
                                       float *matrices,
                                       size_t count);

/*
 Like `mocap_local_matrices`, but writes the matrix of every node relative to the world: the coordinate frame of the
 root's parent.

 # Safety
 `scene` is an open scene, and `matrices` points to room for 16 x `count` floats.
 */
enum mocap_status mocap_world_matrices(const struct mocap_scene *scene,
                                       uint32_t animation,
                                       double tick,
                                       float *matrices,
                                       size_t count);

/*
 Like `mocap_local_matrices`, but writes the matrix of every node relative to its parent in the rest pose.

 # Safety
 `scene` is an open scene, and `matrices` points to room for 16 x `count` floats.
 */
enum mocap_status mocap_rest_local_matrices(const struct mocap_scene *scene,
                                            float *matrices,
                                            size_t count);

/*
 Like `mocap_local_matrices`, but writes the matrix of every node relative to the world in the rest pose.

 # Safety
 `scene` is an open scene, and `matrices` points to room for 16 x `count` floats.
 */
enum mocap_status mocap_rest_world_matrices(const struct mocap_scene *scene,
                                            float *matrices,
                                            size_t count);

/*
 Writes the matrices of the chain from the root to `joint`, the name of a node, at `tick`. Writes at most `count`
 matrices. Returns the number of matrices in the chain, or 0 if the call fails. With `matrices` NULL and `count` 0,
 the call only returns the number.

 `point` is NULL, or three numbers in the coordinate frame of the joint; `point_in_world` then gets its world
 position. In a scene without animations, the chain has the rest pose. For ticks, see `mocap_local_matrices`.

 # Safety
 `scene` is an open scene, `joint` a string, and `matrices` points to room for `count` matrices. `point` and
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

 Returns NULL if the bytes are not a complete and valid packed clip; `mocap_error_text` has the reason. Free the clip
 with `mocap_clip_close`.

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
 The number of nodes of a packed clip, in the order of its source file; 0 for NULL.

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
 Decodes the pose at `tick`. `local` gets the matrices of all nodes relative to their parents, and `world` the
 matrices relative to the world; either may be NULL. `count` is the number of matrices that fit in each buffer, at
 least `mocap_clip_node_count`.

 The call allocates no memory. Only one thread at a time may use a packed clip.

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
 Makes a figure with the character of a scene. The figure stands at the origin and faces +Z. `database` is the `size`
 bytes of a file that `mocap index --pack` wrote, which includes the motions.

 The figure is always in metres with +Y up, and has the nodes of the scene. It takes memory for the pose of every
 frame of the database. You may close the scene after this call. Returns NULL if the character is not a humanoid with
 two legs, or if the bytes are not a database; `mocap_error_text` has the reason. Free the figure with
 `mocap_controller_free`.

 # Safety
 `character` is an open scene, and `database` points to `size` bytes.
 */
struct mocap_controller *mocap_controller_open(const struct mocap_scene *character,
                                               const uint8_t *database,
                                               size_t size);

/*
 Like `mocap_controller_open`, with the motions of `count` scenes instead of a database. The scenes may have any
 skeletons. With `mirror`, the figure also uses the mirror image of each motion. You may close the scenes after this
 call.

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
 Advances by one frame, 1/60 s, controlled by a stick. The input is a velocity over the ground along x and z, in m/s,
 and a facing (`look_x`, `look_z`). While both components of the facing are 0, the figure faces the direction of its
 velocity. Velocity and facing change smoothly. Seen from behind a figure that faces +Z, right is -X.

 The call allocates no memory. Only one thread at a time may use a figure.

 # Safety
 `controller` is a figure that no other thread uses.
 */
enum mocap_status mocap_controller_steer(struct mocap_controller *controller,
                                         float velocity_x,
                                         float velocity_z,
                                         float look_x,
                                         float look_z);

/*
 Advances by one frame towards a trajectory of 12 floats: x and z of the figure's positions in 20, 40 and 60 frames,
 in metres, then x and z of its facings. The call allocates no memory.

 # Safety
 `controller` is a figure that no other thread uses, and `trajectory` points to 12 floats.
 */
enum mocap_status mocap_controller_follow(struct mocap_controller *controller,
                                          const float *trajectory);

/*
 The pose of a figure. `local` gets the matrices of all nodes relative to their parents, and `world` the matrices
 relative to the world; either may be NULL. `count` is the number of matrices that fit in each buffer, at least
 `mocap_node_count` of the figure's scene. If `root` is not NULL, its 4 floats get the figure's position (x and z in
 metres) and facing (x and z of a direction of length 1). The call allocates no memory.

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
 Returns a copy of a scene in metres with +Y up, as `mocap convert` does. `conversion` states the known properties of
 the file; NULL means the default. `mocap_assumption_text` of the copy lists the inferred properties.

 Returns NULL if a number in `conversion` is invalid. The original scene does not change. Free each scene with
 `mocap_close`. Converting the copy again does not change its unit and axes.

 # Safety
 `scene` is an open scene, and `conversion` is NULL or points to a conversion.
 */
struct mocap_scene *mocap_convert(const struct mocap_scene *scene,
                                  const struct mocap_conversion *conversion);

/*
 The number of assumptions about a scene that its file does not state. `mocap_assumption_text` returns each of them.

 # Safety
 `scene` is an open scene.
 */
size_t mocap_assumption_count(const struct mocap_scene *scene);

/*
 An assumption about a scene, counted from 0, with its reason, such as "unit: cm, because the skeleton measures ...".
 NULL beyond the last. The text lives as long as the scene.

 # Safety
 `scene` is an open scene.
 */
const char *mocap_assumption_text(const struct mocap_scene *scene,
                                  size_t assumption);

/*
 Returns a copy of a scene after steps in order, as `mocap edit` does. `steps` is a JSON list. Each step is a string
 in the form of `mocap edit --step`, or an object with the step's name and options.

     mocap_edit(walk, "[\"mirror\", {\"step\": \"smooth\", \"cut-off\": 8}]", NULL, 0)

 `others` are the second motions of the steps that take one, in order, and `other_count` is their number. Lengths in
 steps are in metres, for any unit of the scene. The steps change every animation, including a rest pose in its
 first frame. `mocap_edit_report_text` of the copy returns the changes of each step in each animation.

 Returns NULL if a step is unknown or fails. The original scenes do not change. Free each scene with `mocap_close`.

 # Safety
 `scene` is an open scene, and `steps` is a string that ends with a zero byte. `others` points to `other_count` open
 scenes, or is NULL if `other_count` is 0.
 */
struct mocap_scene *mocap_edit(const struct mocap_scene *scene,
                               const char *steps,
                               const struct mocap_scene *const *others,
                               size_t other_count);

/*
 The number of reports of `mocap_edit` about a scene: one for each step and each animation that it changed.
 `mocap_edit_report_text` returns them.

 # Safety
 `scene` is an open scene.
 */
size_t mocap_edit_report_count(const struct mocap_scene *scene);

/*
 A report, counted from 0: the changes of a step, with units, such as "mirror: 17 pairs of joints exchanged". NULL
 beyond the last. The text lives as long as the scene.

 # Safety
 `scene` is an open scene.
 */
const char *mocap_edit_report_text(const struct mocap_scene *scene,
                                   size_t report);

/*
 Reads a motion file. Returns NULL if reading fails; `mocap_error_text` has the reason, with line and column.

 The formats, detected from the contents, or else from the extension:

 - BVH (`.bvh`) and Acclaim (`.amc` with an `.asf` in the same folder, or `.asf` alone): lengths in the file's unit.
 - C3D (`.c3d`): markers, each a node; lengths in the file's unit, +Y up.
 - TRC (`.trc`): markers, each a node; lengths and axes as in the file.
 - glTF 2.0 (`.glb`, `.gltf`), VRM animations (`.vrma`) and FBX (`.fbx`): the skeleton and its animations; lengths in
   metres, +Y up.
 - USD (`.usda`, `.usdz`): the skeleton and its animations; lengths and axes as in the file.
 - MikuMikuDance (`.vmd`, `.pmx`): a skeleton, or a motion on the model in the same folder or on generic proportions;
   lengths in units of 0.08 m, +Y up.
 - Packed clips (`.mclip`): the skeleton and its animation; lengths in metres.
 - Arrays of bodies (NumPy's `.npz` and `.npy`, PyTorch's `.pt` and `.pth`, pickles `.pkl` and `.pickle`), in layouts
   that are known by their names or shapes; lengths in metres. The reader never runs code of a file.
 - Tables (`.csv`, and `.parquet` in builds with that feature): arrays that this library wrote, and positions.
 - Joint angles of OpenSim (`.mot`, `.sto`): a body of generic proportions; lengths in metres.
 - Robots (URDF `.urdf`, MJCF `.mjcf`): only the skeleton.

 The reader refuses 3ds Max `.bip`, and suggests formats to export instead.

 In BVH, the position channels of the root replace its OFFSET. They are added to the OFFSET if the OFFSET is not near
 zero, but the root position is, in the first frame or in the median of all frames.

 A scene never changes, so any number of threads may use it at the same time. Free it with `mocap_close`.

 # Safety
 `path` is a string that ends with a zero byte.
 */
struct mocap_scene *mocap_open_file(const char *path);

/*
 Reads a motion file with the options of a job. `reading` is the JSON of the job's `read`, described by
 `src/job/job.schema.json`. For example, these options solve a skeleton from markers, with a static trial:

     mocap_open_file_as("walk.trc", "{\"markers\": \"auto\", \"static\": \"standing.trc\"}")

 `mocap_report` returns the residuals of the solution. NULL means no options. The result is as for `mocap_open_file`.

 # Safety
 `path` is a string that ends with a zero byte. `reading` is such a string or NULL.
 */
struct mocap_scene *mocap_open_file_as(const char *path,
                                       const char *reading);

/*
 Like `mocap_open_file`, but reads the `size` bytes of a motion file from memory, and does not keep them. `name` is
 the file name in errors.

 # Safety
 `bytes` points to `size` bytes, and `name` is a string that ends with a zero byte.
 */
struct mocap_scene *mocap_open_memory(const uint8_t *bytes,
                                      size_t size,
                                      const char *name);

/*
 Prepares to retarget poses from the skeleton of `source` to the skeleton of `target`. Both are humanoids with any
 rest pose, unit and axes. `scale` is the length of the target's steps relative to the source's steps, both in
 metres; 0: the ratio of the leg lengths.

 Returns NULL if one of the two is not a humanoid; `mocap_error_text` has the reason. You may close the scenes after
 this call. Free the retargeter with `mocap_retargeter_free`.

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
 Retargets a pose. `source` has the matrix of every node of the source relative to its parent, from
 `mocap_local_matrices` or from a live capture; `source_count` is their number. `local` gets the matrices of the
 target's nodes relative to their parents, and `world` the matrices relative to the world; either may be NULL.
 `count` is the number of matrices that fit in each buffer, at least the target's `mocap_node_count`. Nodes without
 motion keep their rest pose.

 The call allocates no memory. Only one thread at a time may use a retargeter.

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
 The number of bones that are not retargeted. `mocap_unmapped_text` returns each of them with the reason.

 # Safety
 `retargeter` is a retargeter.
 */
size_t mocap_unmapped_count(const struct mocap_retargeter *retargeter);

/*
 A bone that is not retargeted, counted from 0, with the reason, such as "jaw: the target has no such joint"; NULL
 beyond the last. The text lives as long as the retargeter.

 # Safety
 `retargeter` is a retargeter.
 */
const char *mocap_unmapped_text(const struct mocap_retargeter *retargeter,
                                size_t bone);

/*
 Begins to retarget a live motion to a robot, at `fps` poses per second, from 1 to 1000. `source` is the skeleton of
 the poses, a humanoid; its animation, if it has one, determines the floor. `robot` is the path of a URDF or MJCF
 file. With `passes` 2, joints are smooth and feet do not slide, and frames have a delay of 0.6 s. With `passes` 1,
 the delay is 0.1 s.

 Returns NULL if the robot cannot be read, or if the source or the robot is not a humanoid; `mocap_error_text` has
 the reason. You may close the scene after this call. Free the stream with `mocap_robot_stream_free`.

 # Safety
 `source` is an open scene, and `robot` is a string that ends with a zero byte.
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
 The delay of a frame in seconds; 0 for NULL.

 # Safety
 `stream` is NULL or an open stream.
 */
double mocap_robot_stream_delay(const struct mocap_robot_stream *stream);

/*
 The number of joints of the robot. A frame has 7 values more. 0 for NULL.

 # Safety
 `stream` is NULL or an open stream.
 */
size_t mocap_robot_stream_joint_count(const struct mocap_robot_stream *stream);

/*
 The name of a joint, from 0, in the order of a frame; NULL beyond the last. The text lives as long as the stream.

 # Safety
 `stream` is NULL or an open stream.
 */
const char *mocap_robot_stream_joint_name(const struct mocap_robot_stream *stream,
                                          size_t joint);

/*
 Takes the next pose: the matrix of every node of the source relative to its parent, as for `mocap_retarget_pose`.
 Writes the finished frame to `frame`, and whether a frame is finished to `given`. The frame is MuJoCo's `qpos` with
 +Z up. It has the position of the base in metres (x, y, z), its rotation (w, x, y, z), and the joint positions in
 radians or metres. `count` is the number of values that fit in `frame`, at least 7 plus one for each joint.

 Only one thread at a time may use a stream.

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
 Ends a stream, and returns one of the remaining frames with each call, as `mocap_robot_stream_push` does, until
 `given` is false.

 # Safety
 `stream` is a stream that no other thread uses, `frame` points to room for `count` numbers, and `given` to a bool.
 */
enum mocap_status mocap_robot_stream_pull(struct mocap_robot_stream *stream,
                                          double *frame,
                                          size_t count,
                                          bool *given);

/*
 The quality of the frames of the last 30 s, as JSON with a verdict: the report of `mocap robot --json`. "null"
 before the first frame. Free the text with `mocap_text_free`. NULL for NULL.

 # Safety
 `stream` is NULL or a stream that no other thread uses.
 */
char *mocap_robot_stream_report(const struct mocap_robot_stream *stream);

/*
 Runs a job, as `mocap run` does: reads files, edits motions, retargets them, and writes files. `job` is the JSON of
 the job, described by `src/job/job.schema.json`.

     mocap_run("{\"source\": {\"inputs\": [\"walk.bvh\"]}, \"write\": {\"output\": \"walk.glb\"}}")

 A job with `survey` writes no motion: the report has a row for each clip, in `survey`. A job with `graph` writes the
 motion graph of its inputs as JSON. A job with `walk` writes a motion along a walk over a graph.
 `docs/motion-graphs.md` describes both.

 Returns a report as JSON with `files`, `notes` and `warnings`. If the output is worse than the job allows, it has
 `problem`. Free the text with `mocap_text_free`. NULL if the job fails; no file is then written.

 # Safety
 `job` is a string that ends with a zero byte.
 */
char *mocap_run(const char *job);

/*
 Compares a written file with its source, as `mocap verify` does. The output records the changes, and the comparison
 repeats them.

 Returns the differences as JSON with `max_error` in metres and `findings`. Free the text with `mocap_text_free`.
 NULL if the files cannot be compared.

 # Safety
 `source` and `output` are strings that end with a zero byte.
 */
char *mocap_verify(const char *source,
                   const char *output);

/*
 Scores a motion of a robot against its reference, as `mocap score` does. `motion` has arrays of the robot's joints,
 from any program. `robot` is the URDF or MJCF file of the robot. `body` is the robot of the reference, or NULL if a
 person moves in it.

 Returns the report as JSON, with `scores` and `verdict`. Free the text with `mocap_text_free`. NULL if the files
 cannot be compared.

 # Safety
 `reference`, `motion` and `robot` are strings that end with a zero byte. `body` is such a string or NULL.
 */
char *mocap_score(const char *reference,
                  const char *motion,
                  const char *robot,
                  const char *body);

/*
 Frees a string that `mocap_run`, `mocap_verify`, `mocap_score`, `mocap_report` or `mocap_robot_stream_report` has
 returned. NULL is allowed.

 # Safety
 `text` comes from one of these functions, and was not freed before.
 */
void mocap_text_free(char *text);

/*
 Makes a table of a scene. `what` is the name of the table:

 - "angles": the joint angles of a humanoid in degrees, and the position of its pelvis in metres, with the names and
   signs of `docs/biomechanics.md`;
 - "forces": of each force plate of a C3D file, with +Y up: the ground force in newtons, the centre of pressure in
   metres, the free moment in newton metres;
 - "analog": the analog channels of a C3D file, in its units.

 Returns NULL if the scene lacks the data; `mocap_error_text` has the reason. Free the table with `mocap_table_free`.
 You may close the scene after this call.

 # Safety
 `scene` is an open scene, and `what` is a string that ends with a zero byte.
 */
struct mocap_table *mocap_table_new(const struct mocap_scene *scene,
                                    const char *what);

/*
 Frees a table, its strings and its values. NULL is allowed.

 # Safety
 `table` comes from `mocap_table_new`, was not freed before, and is used by no other thread.
 */
void mocap_table_free(struct mocap_table *table);

/*
 The number of columns of a table; 0 for NULL. Time is not a column: the time of row `i` is `i` / `mocap_table_rate`
 seconds.

 # Safety
 `table` is NULL or comes from `mocap_table_new`.
 */
size_t mocap_table_column_count(const struct mocap_table *table);

/*
 The number of rows of a table; 0 for NULL.

 # Safety
 `table` is NULL or comes from `mocap_table_new`.
 */
size_t mocap_table_row_count(const struct mocap_table *table);

/*
 Rows per second; 0 for NULL.

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
 The unit of a column, such as "deg", "m" or "N". The unit of an analog channel is the file's, or empty if the file
 states none. NULL beyond the last. The text lives as long as the table.

 # Safety
 `table` is NULL or comes from `mocap_table_new`.
 */
const char *mocap_table_unit(const struct mocap_table *table,
                             size_t column);

/*
 The values of a table, row by row, with one value for each column; NULL for NULL. The values live as long as the
 table.

 # Safety
 `table` is NULL or comes from `mocap_table_new`.
 */
const double *mocap_table_values(const struct mocap_table *table);

/*
 A report on a scene as JSON, by its name:

 - "solved": the fit of a skeleton to the markers from which it was solved: `markers`, `rms_of_seconds`, `joints`
   with their lengths and deviations, `swaps`, `filled` and `frames`; `null` for other scenes;
 - "recorded": the data of a C3D file besides markers: `events`, `channels` and `plates`; `null` if there are none;
 - "inspect": the output of `mocap info --json`: counts, clips, assumptions, warnings;
 - "bones": the node of each humanoid bone, with confidence and reason;
 - "gait": heel strikes, toe offs and strides of a walk, and the means of a gait laboratory; for an animal on four
   legs, the names of its gaits.

 Free the text with `mocap_text_free`. NULL if there is no such report; `mocap_error_text` has the reason.

 # Safety
 `scene` is an open scene, and `what` is a string that ends with a zero byte.
 */
char *mocap_report(const struct mocap_scene *scene,
                   const char *what);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* MOCAP_H */

/* Retargets the motion of one file to the skeleton of another, and compares the directions of arms and legs.
 *
 *     retarget walk.bvh character.gltf
 */

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <mocap.h>

/* The limbs of both skeletons, by the names of CMU and of MakeHuman. */
static const char *const LIMBS[4][4] = {
    {"LeftArm", "LeftForeArm", "upperarm01.L", "lowerarm01.L"},
    {"RightForeArm", "RightHand", "lowerarm01.R", "wrist.R"},
    {"LeftUpLeg", "LeftLeg", "upperleg01.L", "lowerleg01.L"},
    {"RightLeg", "RightFoot", "lowerleg01.R", "foot.R"},
};

static void check(int holds, const char *what)
{
    if (!holds) {
        fprintf(stderr, "%s: %s\n", what, mocap_error_text());
        exit(1);
    }
}

static void direction(const mocap_scene *scene, const float *world, const char *from, const char *to, double *way)
{
    uint32_t a = mocap_find_node(scene, from), b = mocap_find_node(scene, to);
    check(a != MOCAP_NO_NODE && b != MOCAP_NO_NODE, from);
    double length = 0;
    for (int axis = 0; axis < 3; axis++) {
        way[axis] = world[16 * b + 12 + axis] - world[16 * a + 12 + axis];
        length += way[axis] * way[axis];
    }
    for (int axis = 0; axis < 3; axis++) {
        way[axis] /= sqrt(length);
    }
}

int main(int argc, char **argv)
{
    mocap_scene *source = mocap_open_file(argc > 1 ? argv[1] : NULL);
    mocap_scene *target = mocap_open_file(argc > 2 ? argv[2] : NULL);
    check(source && target, "open");
    mocap_retargeter *retargeter = mocap_retargeter_new(source, target, 0);
    check(retargeter != NULL, "new");
    uint32_t from = mocap_node_count(source), to = mocap_node_count(target);
    float *local = malloc(from * 16 * sizeof *local), *world = malloc(from * 16 * sizeof *world);
    float *posed = malloc(to * 16 * sizeof *posed), *placed = malloc(to * 16 * sizeof *placed);
    check(local && world && posed && placed, "memory");

    double worst = 0;
    for (double tick = 0; tick <= mocap_duration(source, 0); tick += 25) {
        check(mocap_local_matrices(source, 0, tick, local, from) == MOCAP_STATUS_OK, "local");
        check(mocap_world_matrices(source, 0, tick, world, from) == MOCAP_STATUS_OK, "world");
        check(mocap_retarget_pose(retargeter, local, from, posed, placed, to) == MOCAP_STATUS_OK, "pose");
        for (int limb = 0; limb < 4; limb++) {
            double a[3], b[3], square = 0;
            direction(source, world, LIMBS[limb][0], LIMBS[limb][1], a);
            direction(target, placed, LIMBS[limb][2], LIMBS[limb][3], b);
            for (int axis = 0; axis < 3; axis++) {
                square += (a[axis] - b[axis]) * (a[axis] - b[axis]);
            }
            worst = fmax(worst, 2 * asin(0.5 * sqrt(square)) * 57.29577951308232);
        }
    }
    check(worst < 0.1, "a limb points elsewhere");
    /* Request only one of the outputs. */
    float *again = malloc(to * 16 * sizeof *again);
    check(again && mocap_retarget_pose(retargeter, local, from, NULL, again, to) == MOCAP_STATUS_OK, "world alone");
    check(memcmp(again, placed, to * 16 * sizeof *again) == 0, "the same pose twice");
    check(mocap_retarget_pose(retargeter, local, from, again, NULL, to) == MOCAP_STATUS_OK, "local alone");
    check(memcmp(again, posed, to * 16 * sizeof *again) == 0, "the same pose twice");

    /* The error text describes the fault. */
    check(mocap_retarget_pose(retargeter, local, from - 1, posed, placed, to) == MOCAP_STATUS_BAD_ARGUMENT, "short");
    check(strstr(mocap_error_text(), "matrices, and its scene has") != NULL, "short");
    check(mocap_retarget_pose(retargeter, local, from, posed, placed, to - 1) == MOCAP_STATUS_BAD_ARGUMENT, "room");
    local[5] = NAN;
    check(mocap_retarget_pose(retargeter, local, from, posed, placed, to) == MOCAP_STATUS_BAD_ARGUMENT, "NaN");
    check(mocap_retarget_pose(NULL, local, from, posed, placed, to) == MOCAP_STATUS_BAD_ARGUMENT, "NULL");
    check(mocap_retargeter_new(source, target, -1) == NULL, "scale");
    check(mocap_unmapped_count(retargeter) > 0, "unmapped");
    check(strstr(mocap_unmapped_text(retargeter, 0), ": ") != NULL, "unmapped");
    check(mocap_unmapped_text(retargeter, 1000) == NULL, "unmapped");

    /* The retargeter does not need the scenes. */
    mocap_close(source);
    mocap_close(target);
    local[5] = 0;
    check(mocap_retarget_pose(retargeter, local, from, posed, placed, to) == MOCAP_STATUS_OK, "closed");
    mocap_retargeter_free(retargeter);
    mocap_retargeter_free(NULL);
    free(local);
    free(world);
    free(posed);
    free(placed);
    free(again);
    printf("the limbs point where they should\n");
    return 0;
}

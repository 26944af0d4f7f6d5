/* Plays a packed clip, and compares it with its source motion.
 *
 *     clip walk.bvh walk.mclip
 */

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include <mocap.h>

static void check(int holds, const char *what)
{
    if (!holds) {
        fprintf(stderr, "%s: %s\n", what, mocap_error_text());
        exit(1);
    }
}

int main(int count, char **arguments)
{
    check(count == 3, "two files are needed");
    mocap_scene *read = mocap_open_file(arguments[1]);
    check(read != NULL, arguments[1]);
    mocap_scene *walk = mocap_convert(read, NULL);
    check(walk != NULL, arguments[1]);

    FILE *file = fopen(arguments[2], "rb");
    check(file != NULL, arguments[2]);
    static uint8_t bytes[1 << 20];
    size_t size = fread(bytes, 1, sizeof bytes, file);
    fclose(file);
    mocap_clip *clip = mocap_clip_open(bytes, size);
    check(clip != NULL, arguments[2]);

    uint32_t nodes = mocap_clip_node_count(clip);
    check(nodes == mocap_node_count(walk), "nodes");
    check(mocap_clip_duration(clip) == mocap_duration(walk, 0), "duration");
    check(mocap_clip_ticks_per_second(clip) == mocap_ticks_per_second(walk, 0), "rate");
    float *expected = malloc(sizeof(float) * 16 * nodes);
    float *local = malloc(sizeof(float) * 16 * nodes);
    float *world = malloc(sizeof(float) * 16 * nodes);
    for (double tick = 0; tick <= mocap_clip_duration(clip); tick += 1) {
        check(mocap_world_matrices(walk, 0, tick, expected, nodes) == MOCAP_STATUS_OK, "source");
        check(mocap_clip_pose(clip, tick, local, world, nodes) == MOCAP_STATUS_OK, "pose");
        for (uint32_t node = 0; node < nodes; node++) {
            double square = 0;
            for (int axis = 0; axis < 3; axis++) {
                double off = world[16 * node + 12 + axis] - expected[16 * node + 12 + axis];
                square += off * off;
            }
            check(sqrt(square) <= 0.001, "a joint is more than a millimetre from its place");
        }
    }
    check(mocap_clip_pose(clip, 0, NULL, NULL, nodes - 1) == MOCAP_STATUS_BAD_ARGUMENT, "too little room");
    check(mocap_clip_pose(NULL, 0, NULL, NULL, nodes) == MOCAP_STATUS_BAD_ARGUMENT, "no clip");
    check(mocap_clip_open(bytes, size - 1) == NULL, "a clip that is cut off");
    check(mocap_clip_node_count(NULL) == 0, "no clip");
    mocap_clip_close(clip);
    mocap_clip_close(NULL);
    free(expected);
    free(local);
    free(world);
    mocap_close(walk);
    mocap_close(read);
    printf("every joint is where it should be\n");
    return 0;
}

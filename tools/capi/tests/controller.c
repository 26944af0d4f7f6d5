/* Steers a figure by motion matching, with a database and with the motions of scenes.
 *
 *     controller character.bvh walk.bvh walk.mdb
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

/* Walks for three seconds along +Z at 1.2 m/s, and then stands. Returns the distance that the figure walked. */
static float walk(mocap_controller *figure, uint32_t nodes, const char *what)
{
    float root[4], before[4];
    float *local = malloc(sizeof(float) * 16 * nodes);
    float *world = malloc(sizeof(float) * 16 * nodes);
    check(mocap_controller_pose(figure, NULL, NULL, 0, before) == MOCAP_STATUS_OK, what);
    for (int frame = 0; frame < 180; frame++) {
        check(mocap_controller_steer(figure, 0, 1.2f, 0, 0) == MOCAP_STATUS_OK, what);
        check(mocap_controller_pose(figure, local, world, nodes, root) == MOCAP_STATUS_OK, what);
        for (uint32_t number = 0; number < 16 * nodes; number++) {
            check(isfinite(local[number]) && isfinite(world[number]), what);
        }
        check(fabsf(hypotf(root[2], root[3]) - 1) < 1e-4f, "a direction has the length 1");
    }
    check(mocap_controller_pose(figure, local, world, nodes - 1, root) == MOCAP_STATUS_BAD_ARGUMENT, "little room");
    float trajectory[12] = {root[0], root[1], root[0], root[1], root[0], root[1], 0, 1, 0, 1, 0, 1};
    check(mocap_controller_follow(figure, trajectory) == MOCAP_STATUS_OK, what);
    trajectory[5] = NAN;
    check(mocap_controller_follow(figure, trajectory) == MOCAP_STATUS_BAD_ARGUMENT, "a trajectory of NaN");
    free(local);
    free(world);
    return root[1] - before[1];
}

int main(int count, char **arguments)
{
    check(count == 4, "three files are needed");
    mocap_scene *hero = mocap_open_file(arguments[1]);
    check(hero != NULL, arguments[1]);
    mocap_scene *motion = mocap_open_file(arguments[2]);
    check(motion != NULL, arguments[2]);
    uint32_t nodes = mocap_node_count(hero);
    FILE *file = fopen(arguments[3], "rb");
    check(file != NULL, arguments[3]);
    static uint8_t bytes[1 << 21];
    size_t size = fread(bytes, 1, sizeof bytes, file);
    fclose(file);

    const mocap_scene *motions[] = {motion};
    mocap_controller *figures[] = {
        mocap_controller_new(hero, motions, 1, true),
        mocap_controller_open(hero, bytes, size),
    };
    float gone[2];
    for (int which = 0; which < 2; which++) {
        check(figures[which] != NULL, "a figure");
        gone[which] = walk(figures[which], nodes, "a walk");
        check(gone[which] > 2.5f && gone[which] < 4.5f, "it goes three seconds long at 1.2 metres a second");
        mocap_controller_free(figures[which]);
    }
    /* Packed motions are within 0.1 mm of the motions of the files. */
    check(fabsf(gone[0] - gone[1]) < 0.05f, "both ways are one");

    check(mocap_controller_open(hero, bytes, size - 1) == NULL, "a database that is cut off");
    check(mocap_controller_open(hero, NULL, 0) == NULL, "no database");
    check(mocap_controller_open(NULL, bytes, size) == NULL, "no character");
    check(mocap_controller_new(hero, NULL, 0, false) == NULL, "no motions");
    check(mocap_controller_new(hero, motions, 0, false) == NULL, "an empty list");
    check(mocap_controller_steer(NULL, 0, 0, 0, 0) == MOCAP_STATUS_BAD_ARGUMENT, "no figure");
    check(mocap_controller_pose(NULL, NULL, NULL, 0, NULL) == MOCAP_STATUS_BAD_ARGUMENT, "no figure");
    mocap_controller_free(NULL);
    mocap_close(motion);
    mocap_close(hero);
    printf("the figure goes where it is asked to\n");
    return 0;
}

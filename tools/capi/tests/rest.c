/* Prints the nodes of a file, each with its parent and its world position in the rest pose.
 *
 *     rest character.fbx
 */

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include <mocap.h>

int main(int argc, char **argv)
{
    mocap_scene *scene = mocap_open_file(argc > 1 ? argv[1] : NULL);
    if (!scene) {
        fprintf(stderr, "%s\n", mocap_error_text());
        return 1;
    }
    uint32_t count = mocap_node_count(scene);
    float *matrices = malloc(count * 16 * sizeof *matrices);
    if (!matrices || mocap_rest_world_matrices(scene, matrices, count) != MOCAP_STATUS_OK) {
        return 1;
    }
    for (uint32_t node = 0; node < count; node++) {
        const float *place = matrices + 16 * node + 12;
        printf("%s %d", mocap_node_name(scene, node), (int)mocap_node_parent(scene, node));
        for (int axis = 0; axis < 3; axis++) {
            /* Print whole millimetres, because an integer has no -0. */
            printf(" %ld", lround(1000.0 * place[axis]));
        }
        printf("\n");
    }
    free(matrices);
    mocap_close(scene);
    return 0;
}

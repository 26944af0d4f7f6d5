/* Reads the lecture's file, and compares every world matrix with the closed form of the motion.
 *
 *     lecture lecture_Test.bvh
 */

#define _XOPEN_SOURCE 700 /* mkdtemp */

#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <mocap.h>

enum { NODES = 4, THREADS = 4 };

#define CHECK(condition)                                                                                     \
    do {                                                                                                     \
        if (!(condition)) {                                                                                  \
            fprintf(stderr, "%s:%d: %s (%s)\n", __FILE__, __LINE__, #condition, mocap_error_text());         \
            exit(1);                                                                                         \
        }                                                                                                    \
    } while (0)

/* The positions of the nodes at a tick. The shoulder is at (0.1 (tick + 1), 0.02 tick), and the links are 2, 1.5 and
 * 0.5 long. The joints are turned by 5, 10 and 8 degrees times tick + 1, relative to the link before. */
static void arm(double tick, double positions[NODES][2])
{
    static const double lengths[] = {2.0, 1.5, 0.5};
    static const double turns[] = {5.0, 10.0, 8.0};
    double angle = 0.0;
    positions[0][0] = 0.1 * (tick + 1.0);
    positions[0][1] = 0.02 * tick;
    for (int joint = 0; joint < 3; joint++) {
        angle += turns[joint] * (tick + 1.0) * acos(-1.0) / 180.0;
        positions[joint + 1][0] = positions[joint][0] + lengths[joint] * cos(angle);
        positions[joint + 1][1] = positions[joint][1] + lengths[joint] * sin(angle);
    }
}

static void check_all_ticks(const mocap_scene *scene)
{
    float matrices[NODES][16];
    double expected[NODES][2];
    for (double tick = 0.0; tick <= mocap_duration(scene, 0); tick += 0.25) {
        CHECK(mocap_world_matrices(scene, 0, tick, matrices[0], NODES) == MOCAP_STATUS_OK);
        arm(tick, expected);
        for (int node = 0; node < NODES; node++) {
            CHECK(fabs(matrices[node][12] - expected[node][0]) < 1e-6);
            CHECK(fabs(matrices[node][13] - expected[node][1]) < 1e-6);
            CHECK(matrices[node][14] == 0.0f && matrices[node][15] == 1.0f);
        }
    }
}

static void *in_a_thread(void *scene)
{
    check_all_ticks(scene);
    return NULL;
}

static void check_skeleton(const mocap_scene *scene)
{
    static const char *const names[NODES] = {"Shoulder", "Elbow", "Wrist", "EndSite_Wrist"};
    CHECK(mocap_node_count(scene) == NODES);
    for (uint32_t node = 0; node < NODES; node++) {
        CHECK(strcmp(mocap_node_name(scene, node), names[node]) == 0);
        CHECK(mocap_node_parent(scene, node) == (node == 0 ? MOCAP_NO_NODE : node - 1));
        CHECK(mocap_find_node(scene, names[node]) == node);
    }
    CHECK(mocap_node_parent(scene, 0) == MOCAP_NO_NODE && mocap_error_text()[0] == '\0');
    CHECK(mocap_find_node(scene, "Ankle") == MOCAP_NO_NODE);
    CHECK(strcmp(mocap_error_text(), "there is no node named \"Ankle\"") == 0);
    /* Successful calls do not change the text, even a call that frees a scene. */
    const char *text = mocap_error_text();
    mocap_scene *copy = mocap_convert(scene, NULL);
    CHECK(copy != NULL && (mocap_close(copy), strcmp(text, "there is no node named \"Ankle\"") == 0));
    CHECK(mocap_animation_count(scene) == 1 && mocap_error_text()[0] == '\0');
    CHECK(mocap_channel_count(scene, 0) == 3);
    for (size_t channel = 0; channel < 3; channel++) {
        CHECK(mocap_channel_node(scene, 0, channel) == channel);
    }
    CHECK(mocap_channel_node(scene, 0, 3) == MOCAP_NO_NODE);
    CHECK(strstr(mocap_error_text(), "no channel 3: there are 3") != NULL);
    CHECK(mocap_channel_node(scene, 1, 0) == MOCAP_NO_NODE);
    CHECK(strstr(mocap_error_text(), "no animation 1: there are 1") != NULL);
    CHECK(mocap_duration(scene, 0) == 9.0);
    CHECK(fabs(mocap_ticks_per_second(scene, 0) - 10.0) < 1e-6);
    CHECK(mocap_warning_count(scene) == 0);
    CHECK(mocap_warning_text(scene, 0) == NULL);
    CHECK(strstr(mocap_error_text(), "no warning 0: there are 0") != NULL);
}

static void check_poses(const mocap_scene *scene)
{
    float matrices[NODES][16];
    CHECK(mocap_rest_local_matrices(scene, matrices[0], NODES) == MOCAP_STATUS_OK);
    CHECK(matrices[1][12] == 2.0f && matrices[2][12] == 1.5f && matrices[3][12] == 0.5f);
    CHECK(mocap_rest_world_matrices(scene, matrices[0], NODES) == MOCAP_STATUS_OK);
    CHECK(matrices[1][12] == 2.0f && matrices[2][12] == 3.5f && matrices[3][12] == 4.0f);
    CHECK(mocap_local_matrices(scene, 0, 9.0, matrices[0], NODES) == MOCAP_STATUS_OK);
    /* Matrices are stored by columns: the second number is the sine of the shoulder's 50 degrees. */
    CHECK(fabs(matrices[0][1] - sin(50.0 * acos(-1.0) / 180.0)) < 1e-6);
    CHECK(matrices[1][12] == 2.0f);

    /* NaN means tick 0, and a tick beyond an end means that end. */
    float same[NODES][16];
    static const double others[][2] = {{NAN, 0.0}, {-1.0, 0.0}, {INFINITY, 9.0}};
    for (size_t pair = 0; pair < sizeof others / sizeof others[0]; pair++) {
        CHECK(mocap_world_matrices(scene, 0, others[pair][0], matrices[0], NODES) == MOCAP_STATUS_OK);
        CHECK(mocap_world_matrices(scene, 0, others[pair][1], same[0], NODES) == MOCAP_STATUS_OK);
        CHECK(memcmp(matrices, same, sizeof same) == 0);
    }
}

static void check_refusals(const mocap_scene *scene)
{
    float matrices[NODES][16];
    memset(matrices, 0, sizeof matrices);
    CHECK(mocap_world_matrices(scene, 0, 0.0, matrices[0], NODES - 1) == MOCAP_STATUS_BAD_ARGUMENT);
    CHECK(strstr(mocap_error_text(), "4 nodes") != NULL);
    CHECK(matrices[0][0] == 0.0f);
    CHECK(mocap_world_matrices(scene, 1, 0.0, matrices[0], NODES) == MOCAP_STATUS_BAD_ARGUMENT);
    CHECK(mocap_world_matrices(scene, 0, 0.0, NULL, NODES) == MOCAP_STATUS_BAD_ARGUMENT);
    CHECK(mocap_world_matrices(NULL, 0, 0.0, matrices[0], NODES) == MOCAP_STATUS_BAD_ARGUMENT);
    CHECK(mocap_node_name(scene, NODES) == NULL);
    CHECK(strstr(mocap_error_text(), "no node 4: there are 4") != NULL);
    CHECK(mocap_node_parent(scene, NODES) == MOCAP_NO_NODE);
    CHECK(mocap_node_count(NULL) == 0);

    CHECK(mocap_open_file("/no/such/file.bvh") == NULL);
    CHECK(strstr(mocap_error_text(), "/no/such/file.bvh") != NULL);
    CHECK(mocap_open_file(NULL) == NULL);
    static const char text[] = "HIERARCHY\nROOT a {\n  OFFSET 0 zero 0\n}\n";
    CHECK(mocap_open_memory((const uint8_t *)text, sizeof text - 1, "a.bvh") == NULL);
    CHECK(strncmp(mocap_error_text(), "a.bvh:3:12: error[invalid-number]", 33) == 0);
    mocap_close(NULL);
}

/* J0 L1 J1 L2 J2 of the wrist at tick 9: turns of 50, 100 and 80 degrees, links 2 and 1.5 long. */
static void check_chain(const mocap_scene *scene)
{
    enum { LENGTH = 5 };
    static const double turns[] = {50.0, 100.0, 80.0};
    static const float links[] = {2.0f, 1.5f};
    static const float tip[] = {0.5f, 0.0f, 0.0f};
    mocap_chain_matrix chain[LENGTH];
    float world[3];
    double expected[NODES][2], angle = 0.0;
    arm(9.0, expected);
    CHECK(mocap_chain(scene, 0, 9.0, "Wrist", NULL, NULL, NULL, 0) == LENGTH);
    CHECK(mocap_chain(scene, 0, 9.0, "Wrist", tip, world, chain, LENGTH) == LENGTH);
    CHECK(fabs(world[0] - expected[3][0]) < 1e-5 && fabs(world[1] - expected[3][1]) < 1e-5);
    for (uint32_t at = 0; at < LENGTH; at++) {
        const uint32_t joint = (at + 1) / 2;
        const int is_joint = at % 2 == 0;
        CHECK(chain[at].letter == (is_joint ? 'J' : 'L') && chain[at].index == joint && chain[at].node == joint);
        const double turn = is_joint ? turns[joint] * acos(-1.0) / 180.0 : 0.0;
        angle += turn;
        CHECK(fabs(chain[at].matrix[0] - cos(turn)) < 1e-6 && fabs(chain[at].matrix[1] - sin(turn)) < 1e-6);
        CHECK(fabs(chain[at].product[0] - cos(angle)) < 1e-6 && fabs(chain[at].product[1] - sin(angle)) < 1e-6);
        CHECK(fabs(chain[at].product[12] - expected[joint][0]) < 1e-5);
        CHECK(fabs(chain[at].product[13] - expected[joint][1]) < 1e-5);
        if (!is_joint) {
            CHECK(chain[at].matrix[12] == links[joint - 1] && chain[at].matrix[13] == 0.0f);
        }
    }
    /* The call writes at most `count` matrices. */
    chain[1].index = 77;
    CHECK(mocap_chain(scene, 0, 9.0, "Wrist", NULL, NULL, chain, 1) == LENGTH && chain[1].index == 77);
    CHECK(mocap_chain(scene, 0, 9.0, "Wirst", NULL, NULL, NULL, 0) == 0);
    CHECK(strstr(mocap_error_text(), "no joint is called \"Wirst\"") != NULL);
    CHECK(mocap_chain(scene, 1, 9.0, "Wrist", NULL, NULL, NULL, 0) == 0);
    CHECK(strstr(mocap_error_text(), "no animation 1: there are 1") != NULL);
    CHECK(mocap_chain(scene, 0, 9.0, NULL, NULL, NULL, NULL, 0) == 0);
    CHECK(mocap_chain(scene, 0, 9.0, "Wrist", NULL, NULL, NULL, 1) == 0);
    CHECK(mocap_chain(scene, 0, 9.0, "Wrist", tip, NULL, NULL, 0) == 0);
    CHECK(strcmp(mocap_error_text(), "point_in_world is NULL") == 0);
}

/* Runs jobs, which read and write files. */
static void check_jobs(const char *path)
{
    char job[1024], output[] = "/tmp/mocap-job-XXXXXX";
    CHECK(mkdtemp(output) != NULL);
    snprintf(job, sizeof job,
             "{\"source\": {\"inputs\": [\"%s\"]}, \"write\": {\"output\": \"%s/arm.bvh\"}}", path, output);
    char *report = mocap_run(job);
    CHECK(report != NULL && strstr(report, "\"name\":\"arm.bvh\"") != NULL);
    mocap_text_free(report);
    mocap_text_free(NULL);
    char written[64];
    snprintf(written, sizeof written, "%s/arm.bvh", output);
    mocap_scene *scene = mocap_open_file(written);
    CHECK(scene != NULL && mocap_node_count(scene) == NODES);
    mocap_close(scene);
    CHECK(remove(written) == 0 && remove(output) == 0);
    snprintf(job, sizeof job, "{\"source\": {\"inputs\": [\"%s\"]}, \"survey\": {}}", path);
    char *survey = mocap_run(job);
    CHECK(survey != NULL && strstr(survey, "\"verdict\":\"") != NULL);
    mocap_text_free(survey);
    CHECK(mocap_run("{\"wirte\": {}}") == NULL);
    CHECK(strstr(mocap_error_text(), "did you mean write?") != NULL);
    CHECK(mocap_run(NULL) == NULL);
}

/* At twice the speed, the pose at each time equals the original pose at twice the time. */
static void check_edits(const mocap_scene *scene)
{
    float matrices[NODES][16], edited_matrices[NODES][16];
    mocap_scene *fast = mocap_edit(scene, "[{\"step\": \"warp\", \"speed\": 2}]", NULL, 0);
    CHECK(fast != NULL && mocap_edit_report_count(fast) == 1 && mocap_edit_report_count(scene) == 0);
    CHECK(strncmp(mocap_edit_report_text(fast, 0), "warp: 0.90 s long, now 0.40 s", 29) == 0);
    CHECK(mocap_edit_report_text(fast, 1) == NULL);
    CHECK(mocap_world_matrices(fast, 0, 3.0, edited_matrices[0], NODES) == MOCAP_STATUS_OK);
    CHECK(mocap_world_matrices(scene, 0, 6.0, matrices[0], NODES) == MOCAP_STATUS_OK);
    for (int node = 0; node < NODES; node++) {
        for (int axis = 12; axis < 15; axis++) {
            CHECK(fabs(edited_matrices[node][axis] - matrices[node][axis]) < 1e-6);
        }
    }
    /* The last frame of the first motion is the first frame of the second. */
    const mocap_scene *others[] = {scene};
    mocap_scene *both = mocap_edit(scene, "[\"concat:align=false\"]", others, 1);
    CHECK(both != NULL && mocap_duration(both, 0) == 18.0);
    mocap_close(both);
    mocap_close(fast);

    CHECK(mocap_edit(scene, "[\"smoth\"]", NULL, 0) == NULL);
    CHECK(strstr(mocap_error_text(), "did you mean smooth?") != NULL);
    CHECK(mocap_edit(scene, "[\"mirror\"]", NULL, 0) == NULL);
    CHECK(strstr(mocap_error_text(), "the skeleton is not a humanoid") != NULL);
    CHECK(mocap_edit(scene, "[\"concat\"]", NULL, 0) == NULL);
    CHECK(strstr(mocap_error_text(), "uses the motion number 2, but the number of motions is 1") != NULL);
    CHECK(mocap_edit(scene, "mirror", NULL, 0) == NULL);
    CHECK(strstr(mocap_error_text(), "steps must be a JSON list") != NULL);
    CHECK(mocap_edit(scene, "[\"concat\"]", NULL, 1) == NULL);
    CHECK(strcmp(mocap_error_text(), "others is NULL") == 0);
}

/* The file states neither its unit nor its up axis. They are inferred, or stated by the caller. */
static void check_conversions(const mocap_scene *scene)
{
    float matrices[NODES][16];
    CHECK(mocap_assumption_count(scene) == 0);
    mocap_scene *guessed = mocap_convert(scene, NULL);
    CHECK(guessed != NULL && mocap_assumption_count(guessed) == 2);
    CHECK(strncmp(mocap_assumption_text(guessed, 0), "unit: ", 6) == 0);
    CHECK(strncmp(mocap_assumption_text(guessed, 1), "up: y, because ", 15) == 0);
    CHECK(mocap_assumption_text(guessed, 2) == NULL);
    CHECK(strstr(mocap_error_text(), "no assumption 2: there are 2") != NULL);
    mocap_close(guessed);

    mocap_conversion named = {0};
    named.metres_per_unit = 0.5;
    named.frame_rate = 20.0;
    named.up = MOCAP_UP_Z;
    mocap_scene *converted = mocap_convert(scene, &named);
    CHECK(converted != NULL && mocap_assumption_count(converted) == 0);
    CHECK(mocap_duration(converted, 0) == 18.0 && mocap_duration(scene, 0) == 9.0);
    CHECK(mocap_world_matrices(converted, 0, 18.0, matrices[0], NODES) == MOCAP_STATUS_OK);
    double expected[NODES][2];
    arm(9.0, expected);
    for (int node = 0; node < NODES; node++) {
        CHECK(fabs(matrices[node][12] - 0.5 * expected[node][0]) < 1e-6);
        CHECK(fabs(matrices[node][13]) < 1e-6);
        CHECK(fabs(matrices[node][14] + 0.5 * expected[node][1]) < 1e-6);
    }
    mocap_close(converted);

    named.up = MOCAP_UP_NEG_Y;
    converted = mocap_convert(scene, &named);
    CHECK(converted != NULL && mocap_world_matrices(converted, 0, 18.0, matrices[0], NODES) == MOCAP_STATUS_OK);
    for (int node = 0; node < NODES; node++) {
        CHECK(fabs(matrices[node][13] + 0.5 * expected[node][1]) < 1e-6);
    }
    mocap_close(converted);

    named.frame_rate = -1.0;
    CHECK(mocap_convert(scene, &named) == NULL);
    CHECK(strstr(mocap_error_text(), "frame rate must be finite and above 0, got -1") != NULL);
    named.up = 7;
    CHECK(mocap_convert(scene, &named) == NULL);
    CHECK(strstr(mocap_error_text(), "up must be MOCAP_UP_AUTO or an axis, such as MOCAP_UP_Y, got 7") != NULL);
    CHECK(mocap_convert(NULL, NULL) == NULL);
}

int main(int argc, char **argv)
{
    CHECK(argc == 2);
    CHECK(mocap_interface_version() == MOCAP_INTERFACE_VERSION);
    CHECK(mocap_version()[0] != '\0');
    mocap_scene *scene = mocap_open_file(argv[1]);
    CHECK(scene != NULL);

    check_skeleton(scene);
    check_conversions(scene);
    check_edits(scene);
    check_jobs(argv[1]);
    check_poses(scene);
    check_chain(scene);
    check_refusals(scene);

    pthread_t threads[THREADS];
    for (int thread = 0; thread < THREADS; thread++) {
        CHECK(pthread_create(&threads[thread], NULL, in_a_thread, scene) == 0);
    }
    for (int thread = 0; thread < THREADS; thread++) {
        CHECK(pthread_join(threads[thread], NULL) == 0);
    }
    mocap_close(scene);
    puts("the arm stands where the lecture puts it");
    return 0;
}

"""Forward kinematics for the peers that only parse numbers. Matrices have four rows, from node to parent."""

import math

IDENTITY = [[1.0 if row == column else 0.0 for column in range(4)] for row in range(4)]


def product(a, b):
    return [[sum(a[row][k] * b[k][column] for k in range(4)) for column in range(4)] for row in range(4)]


def translation(position):
    matrix = [row[:] for row in IDENTITY]
    for axis in range(3):
        matrix[axis][3] = position[axis]
    return matrix


def scaling(factors):
    matrix = [row[:] for row in IDENTITY]
    for axis in range(3):
        matrix[axis][axis] = factors[axis]
    return matrix


def rotation_about(axis, degrees):
    """A counter-clockwise rotation about axis 0, 1 or 2."""
    cosine, sine = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    first, second = (axis + 1) % 3, (axis + 2) % 3
    matrix = [row[:] for row in IDENTITY]
    matrix[first][first], matrix[first][second] = cosine, -sine
    matrix[second][first], matrix[second][second] = sine, cosine
    return matrix


def rotation(w, x, y, z):
    """The matrix of a unit quaternion."""
    return [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y), 0.0],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x), 0.0],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y), 0.0],
        [0.0, 0.0, 0.0, 1.0],
    ]


def position(matrix):
    return [matrix[axis][3] for axis in range(3)]

// Where a pixel of a slice lies (passes/positions/grid.h, grid_uniforms.h).

// Position + tap shift of the block's first pixel, and steps to the next pixel along x and y, modulo
// 8 voxels: words of 3 whole and 29 fraction bits, and low_bits further fraction bits.
uniform ivec3 origin, du, dv;
uniform ivec3 origin_low, du_low, dv_low;
uniform int low_bits;

// Of pixel p from the block's first one on, in fixed point with carry: the first tap's place in its
// cell, and the fraction rounded to 24 bits.
void grid_position(ivec2 p, out ivec3 start, out vec3 t)
{
    ivec3 low = origin_low + p.x * du_low + p.y * dv_low;
    ivec3 position = origin + p.x * du + p.y * dv + (low >> low_bits);
    start = (position >> 29) & 7;
    t = vec3((((position >> 4) & 0x1ffffff) + 1) >> 1) * (1.0 / 16777216.0);
}

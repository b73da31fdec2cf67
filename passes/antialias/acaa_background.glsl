// Fragment shader: counts the samples without a surface. Behind acaa_head.glsl.
void main()
{
    weft_write_background();
}

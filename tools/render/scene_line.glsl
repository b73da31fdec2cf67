// Fragment shader of lines and points (tools/render/frame.c): that they are there is all.
void main()
{
    weft_write(vec4(1.0), 1u);
}

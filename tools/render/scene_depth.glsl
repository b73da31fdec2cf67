// Fragment shader of shadow maps, and of stages that draw depths alone.
void main()
{
}

// Fragment shader of shadow maps: depth alone.
void main()
{
}

// SPDX-License-Identifier: BSD-3-Clause
// weft plan and weft validate as their users see them, and what they refuse.
int main(void)
{
    return 0;
}

// irq_sim.c is built into kernels only; as a module it needs one function that is not exported.
#include <linux/irq.h>
#include <linux/irqdesc.h>
#include <linux/module.h>
#define irq_to_desc(irq) irq_data_to_desc(irq_get_irq_data(irq))
#include "irq_sim.c"
MODULE_LICENSE("GPL");

static const bound bounds[] = {{DDOF_QUALITY_GOOD,16,0,0,1}};

#pragma once
#include "MrmlFixture.h"

/// A model to query.
class QueryTest : public MrmlFixture {
protected:
  QueryTest() {
    EXPECT_TRUE(logic->Reconstruct(addParameters(addVolume()))) << logic->GetLastError();
    model = logic->GetLastJob()->GetModelNode();
  }
  vtkMRMLInnerGSModelNode* model = nullptr;
};
